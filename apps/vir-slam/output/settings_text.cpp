#include "output/settings_text.h"

#include <set>

#include "robots/rendezvous_options.h"
#include "setup/record_options.h"
#include "setup/run_options.h"
#include "vir/core/ini_writer.h"
#include "vir/roles/estimator_registry.h"
#include "vir/roles/live_source.h"
#include "vir/roles/recorded_source.h"
#include "vir/roles/rendezvous_registry.h"
#include "vir/roles/sensor.h"
#include "vir/team/joint_solution.h"

namespace vir::app {
namespace {

constexpr const char* kSimulator = "simulator";

/// Collects names instead of values.
class KeyLister final : public OptionVisitor {
 public:
  void startRole(const std::string& role) { role_ = role; }
  void section(const std::string& name, const std::string&) override { section_ = name; }
  void value(const char* key, bool&, const char*) override { add(key); }
  void value(const char* key, int&, Bounds<int>, const char*) override { add(key); }
  void value(const char* key, double&, Bounds<double>, const char*) override { add(key); }
  void value(const char* key, std::string&, const char*) override { add(key); }
  void value(const char* key, std::vector<double>&, std::size_t, const char*) override { add(key); }
  void choice(const char* key, std::string&, const std::vector<std::string>&,
              const char*) override {
    add(key);
  }
  std::string text() const {
    std::string out;
    for (const std::string& line : lines_) out += line + "\n";
    return out;
  }

 private:
  void add(const char* key) { lines_.insert(role_ + " " + section_ + "." + key); }

  std::string role_, section_;
  std::set<std::string> lines_;
};

void describeEstimator(const std::string& name, OptionVisitor* v) {
  RunOptions run;
  run.driver = name;
  describe(*v, run);
  roles::estimatorSettings(name)->describe(*v);
}

void describeRendezvous(const std::string& name, OptionVisitor* v) {
  RendezvousRunOptions run;
  team::JointOptions joint;
  run.driver = name;
  describe(*v, run);
  roles::createRendezvous(name)->describe(*v);
  team::describe(*v, joint);
}

}  // namespace

std::string settingsText(const std::string& name) {
  IniWriter writer(IniWriter::Style::reference);
  const std::string head =
      "// Every setting with its default. Written by: vir-slam plugins " + name + "\n\n";
  for (const auto& e : roles::registeredEstimators()) {
    if (e.name != name) continue;
    describeEstimator(name, &writer);
    return head + writer.text();
  }
  for (const auto& r : roles::registeredRendezvous()) {
    if (r.name != name) continue;
    describeRendezvous(name, &writer);
    return head + writer.text();
  }
  const auto sensor = roles::openSensor(name);
  if (auto* recorded = sensor->recorded()) recorded->describe(writer);
  if (auto* live = sensor->live()) live->describe(writer);
  return head + writer.text();
}

std::string settingsKeys() {
  KeyLister keys;
  keys.startRole("estimator");
  for (const auto& e : roles::registeredEstimators()) describeEstimator(e.name, &keys);
  keys.startRole("rendezvous");
  for (const auto& r : roles::registeredRendezvous()) describeRendezvous(r.name, &keys);
  for (const auto& s : roles::registeredSensors()) {
    const auto sensor = roles::openSensor(s.alias);
    if (auto* recorded = sensor->recorded()) {
      keys.startRole(s.alias == kSimulator ? kSimulator : "source");
      recorded->describe(keys);
    } else if (auto* live = sensor->live()) {
      keys.startRole("live");
      live->describe(keys);
    }
  }
  keys.startRole("live");
  RecordOptions record;
  describe(keys, record);
  return keys.text();
}

}  // namespace vir::app
