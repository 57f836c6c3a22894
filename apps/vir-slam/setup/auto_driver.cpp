#include "setup/auto_driver.h"

#include <algorithm>
#include <map>
#include <set>

#include "vir/core/text.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir/roles/estimator_registry.h"

namespace vir::app {
namespace {

/// Of the estimators that a recording has everything for the one that needs most of it; among
/// equals the first by name. The others tell by how much they miss.
struct Candidate {
  std::string name;
  std::vector<roles::EstimatorInput> inputs;
  std::set<int> needed, found;

  bool complete() const { return !needed.empty() && found.size() == needed.size(); }
};

/// The estimators as they are set: labels of inputs are settings.
std::vector<Candidate> candidates(const Settings& settings) {
  std::vector<Candidate> out;
  for (const roles::EstimatorEntry& e : roles::registeredEstimators()) {
    const auto estimator = roles::estimatorSettings(e.name);
    SettingsReader reader(settings);
    estimator->describe(reader);
    Candidate c{e.name, estimator->inputs(), {}, {}};
    for (const roles::EstimatorInput& input : c.inputs) {
      if (input.group > 0) c.needed.insert(input.group);
    }
    if (!c.needed.empty()) out.push_back(std::move(c));
  }
  // The most demanding first: once it has all, nothing can beat it and the reading may end.
  std::stable_sort(out.begin(), out.end(), [](const Candidate& a, const Candidate& b) {
    return a.needed.size() > b.needed.size();
  });
  return out;
}

/// All words that are set there.
std::set<std::string> wordsIn(const Settings& settings, const std::vector<std::string>& sections) {
  std::set<std::string> out;
  for (const std::string& section : sections) {
    for (const std::string& key : settings.keys(section)) {
      for (const std::string_view word : wordsOf(settings.find(section, key)->value)) {
        out.emplace(word);
      }
    }
  }
  return out;
}

}  // namespace

std::string driverFor(const std::string& driver, const Settings& settings,
                      const std::string& rawlog) {
  if (driver != kAutoDriver) return driver;
  std::vector<Candidate> all = candidates(settings);
  if (all.empty()) return driver;  // estimatorSettings() then says what there is
  rawlog::RawlogReader reader(rawlog);
  while (const auto o = reader.next()) {
    for (Candidate& c : all) {
      for (const roles::EstimatorInput& input : c.inputs) {
        if (input.group > 0 && roles::matches(input, *o)) c.found.insert(input.group);
      }
    }
    if (all.front().complete()) return all.front().name;
  }
  for (const Candidate& c : all) {
    if (c.complete()) return c.name;
  }
  return all.front().name;  // which then says what it misses
}

std::string driverForLive(const std::string& driver, const Settings& settings,
                          const std::vector<std::string>& sensor_sections) {
  if (driver != kAutoDriver) return driver;
  std::vector<Candidate> all = candidates(settings);
  if (all.empty()) return driver;
  const std::set<std::string> words = wordsIn(settings, sensor_sections);
  for (Candidate& c : all) {
    for (const roles::EstimatorInput& input : c.inputs) {
      if (input.group > 0 && words.count(input.label) > 0) c.found.insert(input.group);
    }
    if (c.complete()) return c.name;
  }
  return all.front().name;
}

void acceptOtherDrivers(const std::string& asked, const std::string& chosen,
                        SettingsReader* reader) {
  if (asked != kAutoDriver) return;
  for (const roles::EstimatorEntry& e : roles::registeredEstimators()) {
    if (e.name != chosen) roles::estimatorSettings(e.name)->describe(*reader);
  }
}

}  // namespace vir::app
