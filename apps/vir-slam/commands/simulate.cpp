/// vir-slam simulate INI --out FILE.rawlog: robots in a made-up world, a rawlog each.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <sstream>

#include "commands/commands.h"
#include "output/console.h"
#include "output/overwrite.h"
#include "recordings/companion.h"
#include "recordings/rawlog_recorder.h"
#include "vir/core/settings.h"
#include "vir/roles/recorded_source.h"
#include "vir/roles/sensor.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

struct SimulateArguments {
  std::string ini, out;
  std::vector<std::string> set;
  int compression = 1;
};

/// The value of `key` in [simulator], or what it is by default.
std::string simulatorKey(const Settings& settings, const char* key, const std::string& by_default) {
  const Setting* setting = settings.find("simulator", key);
  return setting != nullptr ? setting->value : by_default;
}

/// One sensor, one rawlog.
void simulateRobot(const Settings& all, const std::string& robot, const std::string& out,
                   int compression) {
  const auto sensor = roles::openSensor("simulator");
  roles::RecordedSource* source = sensor->recorded();
  if (source == nullptr) throw UsageError("'simulator' is not a simulated sensor");
  Settings settings = all;
  if (!robot.empty()) settings.set("simulator.robot=" + robot);
  SettingsReader reader(settings);
  source->describe(reader);
  reader.finish();
  recordToRawlog({sensor.get(), source, out, compression, "simulate", "", false});
}

void run(const SimulateArguments& a, const Common& common) {
  loadPlugins(common, {roles::PluginRole::sensor});
  requireRawlogName(a.out);
  Settings settings;
  if (!a.ini.empty()) {
    requireFile(a.ini, "ini");
    settings = Settings::fromFile(a.ini);
  }
  for (const std::string& assignment : a.set) settings.set(assignment);
  std::istringstream letters(simulatorKey(settings, "robots", "A"));
  std::vector<std::string> robots;
  for (std::string robot; letters >> robot;) robots.push_back(robot);
  if (robots.size() < 2 || !simulatorKey(settings, "robot", "").empty()) {
    refuseToOverwrite(a.out, Written::rawlog, common);
    simulateRobot(settings, "", a.out, a.compression);
    return;
  }
  const std::string extension = a.out.substr(stemOfRawlog(a.out).size());
  const auto outOf = [&](const std::string& robot) {
    return stemOfRawlog(a.out) + "_" + robot + extension;
  };
  for (const std::string& robot : robots) refuseToOverwrite(outOf(robot), Written::rawlog, common);
  for (const std::string& robot : robots) {
    std::printf("robot %s\n", robot.c_str());
    simulateRobot(settings, robot, outOf(robot), a.compression);
    std::printf("\n");
  }
}

}  // namespace

void addSimulate(CLI::App& app, Common& common) {
  const auto a = std::make_shared<SimulateArguments>();
  CLI::App* command = app.add_subcommand(
      "simulate",
      "Record robots in a made-up world\n"
      "Examples:\n"
      "  vir-slam simulate ini/simulate_two_robots.ini --out two.rawlog   (two_A and "
      "two_B.rawlog)\n"
      "  vir-slam simulate --out flight.rawlog --set Robot_A.duration_s=30\n"
      "  vir-slam simulate ini/simulate_two_robots.ini --out b.rawlog --set simulator.robot=B\n"
      "  vir-slam simulate ini/simulate_two_robots.ini --out t.rawlog --set simulator.tracks=true\n"
      "Every setting: vir-slam plugins simulator");
  command->add_option("INI", a->ini, "Settings of the world (without: one robot, all by default)");
  command
      ->add_option("--out", a->out,
                   "Rawlog to write; with several robots and no simulator.robot one each, with the "
                   "robot's letter added to the name")
      ->required();
  command->add_option("--set", a->set, "Section.key=value, e.g. simulator.seed=7")
      ->allow_extra_args(false);
  command->add_option("--compression", a->compression, "0 (none) to 9, of the rawlog itself")
      ->check(CLI::Range(0, 9))
      ->capture_default_str();
  command->callback([a, &common] {
    catchInterrupt();
    run(*a, common);
  });
}

}  // namespace vir::app
