#include "rendezvous_robots.h"

#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <set>

#include "companion.h"
#include "console.h"
#include "vir/core/ini_writer.h"
#include "vir/pipeline/estimator_registry.h"
#include "vir/pipeline/mrpt_pose.h"
#include "vir/pipeline/mrpt_time.h"
#include "vir/pipeline/offline_run.h"
#include "vir/pipeline/rawlog_reader.h"
#include "vir/pipeline/rendezvous_registry.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

constexpr const char* kRobotsSection = "Robots";

/// The name becomes part of file names.
void checkName(const std::string& name, const std::string& text) {
  const bool plain = !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
  if (!plain) {
    throw UsageError("'" + text + "': a robot's name is made of letters, digits, _ and -");
  }
}

/// "NAME" or "NAME:ID"; `place` in the list stands in for an id.
RobotFile robotOf(const std::string& text, const std::string& rawlog, std::size_t place) {
  RobotFile robot;
  const auto colon = text.find(':');
  robot.name = text.substr(0, colon);
  robot.rawlog = rawlog;
  checkName(robot.name, text);
  if (colon != std::string::npos) {
    const char* const first = text.data() + colon + 1;
    const char* const last = text.data() + text.size();
    const auto number = std::from_chars(first, last, robot.id);
    if (number.ec != std::errc() || number.ptr != last) {
      throw UsageError("'" + text + "': behind the colon stands the robot's id, a whole number");
    }
  } else if (robot.name.size() == 1 && std::isalpha(static_cast<unsigned char>(robot.name[0]))) {
    robot.id = std::toupper(static_cast<unsigned char>(robot.name[0])) - 'A';
  } else {
    robot.id = static_cast<int>(place);
  }
  return robot;
}

std::vector<RobotFile> robotFiles(const Settings& settings,
                                  const std::vector<std::string>& rawlogs) {
  std::vector<RobotFile> robots;
  for (const std::string& text : rawlogs) {
    const auto equals = text.find('=');
    if (equals == std::string::npos) {
      throw UsageError("--rawlog " + text + ": write NAME=FILE or NAME:ID=FILE");
    }
    robots.push_back(robotOf(text.substr(0, equals), text.substr(equals + 1), robots.size()));
  }
  if (rawlogs.empty() && settings.hasSection(kRobotsSection)) {
    for (const std::string& key : settings.keys(kRobotsSection)) {
      fs::path path = settings.find(kRobotsSection, key)->value;
      // A path in an ini is relative to that ini.
      if (path.is_relative()) path = fs::path(settings.name()).parent_path() / path;
      robots.push_back(robotOf(key, path.string(), robots.size()));
    }
  }
  if (robots.size() < 2) {
    throw UsageError(
        "a rendezvous takes two or more robots: give --rawlog NAME=FILE for each, or "
        "NAME = FILE in [Robots] of " +
        settings.name());
  }
  std::set<std::string> names;
  std::set<int> ids;
  for (const RobotFile& r : robots) {
    if (!names.insert(r.name).second) throw UsageError("two robots are called " + r.name);
    if (!ids.insert(r.id).second) {
      throw UsageError("two robots have the id " + std::to_string(r.id) +
                       ": give them with NAME:ID=FILE");
    }
    requireFile(r.rawlog, "rawlog");
  }
  return robots;
}

/// Reads every setting of a robot's run; throws SettingsError for what nobody knows.
std::unique_ptr<Estimator> configured(const Prepared& p, const RobotFile& robot,
                                      OptionVisitor* also) {
  auto estimator = createEstimator(p.run.driver);
  SettingsReader reader(robot.settings);
  reader.ignoreSection(kRobotsSection);
  RunOptions run;
  RendezvousRunOptions rendezvous;
  describe(reader, run);
  estimator->describe(reader);
  describe(reader, rendezvous);
  const auto solver = createRendezvous(p.rendezvous.driver);
  solver->describe(reader);
  JointOptions joint;
  vir::describe(reader, joint);
  reader.ignoreUnknownFrom(robot.companion);
  reader.finish();
  if (also != nullptr) {
    describe(*also, run);
    estimator->describe(*also);
    describe(*also, rendezvous);
    solver->describe(*also);
    vir::describe(*also, joint);
  }
  return estimator;
}

Trajectory groundTruthOf(const std::string& rawlog) {
  Trajectory out;
  RawlogReader reader(rawlog);
  while (const auto observation = reader.next()) {
    if (observation->sensorLabel != "GT") continue;
    const auto pose = std::dynamic_pointer_cast<mrpt::obs::CObservationRobotPose>(observation);
    if (!pose) continue;
    const TimeNs t = fromMrptTime(pose->timestamp);
    if (out.empty() || t > out.back().t) out.push_back({t, fromMrptPose(pose->pose.mean)});
  }
  return out;
}

}  // namespace

std::unique_ptr<Rendezvous> Prepared::createSolver(const LogSink& log) const {
  auto solver = createRendezvous(rendezvous.driver);
  SettingsReader reader(settings);
  solver->describe(reader);
  solver->start(log);
  return solver;
}

Prepared prepareRobots(const std::string& ini, const std::vector<std::string>& rawlogs,
                       const std::vector<std::string>& assignments, const Common& common) {
  Prepared out;
  out.settings = Settings::fromFile(ini);
  for (const std::string& assignment : assignments) out.settings.set(assignment);
  SettingsReader own(out.settings);
  describe(own, out.run);
  describe(own, out.rendezvous);
  vir::describe(own, out.joint);
  out.robots = robotFiles(out.settings, rawlogs);
  loadPlugins(common);
  for (std::size_t i = 0; i < out.robots.size(); ++i) {
    RobotFile& robot = out.robots[i];
    robot.settings = out.settings;
    robot.companion = companionOf(robot.rawlog);
    if (!robot.companion.empty()) {
      robot.settings.mergeDefaults(Settings::fromFile(robot.companion));
    }
    IniWriter used(IniWriter::Style::values);
    configured(out, robot, i == 0 ? &used : nullptr);
    if (i == 0) out.used_ini = used.text();
  }
  return out;
}

RobotRecord runRobot(const Prepared& prepared, std::size_t i, const ResultsFolder& folder,
                     const LogSink& log, const std::function<void(double)>& progress) {
  const RobotFile& robot = prepared.robots[i];
  RobotRecord record;
  record.name = robot.name;
  record.id = robot.id;
  RecordingEstimator estimator(configured(prepared, robot, nullptr), prepared.rendezvous.peer_label,
                               &record);
  OfflineRunOptions options;
  options.estimator = prepared.run.driver;
  options.rawlog = robot.rawlog;
  options.start_offset_s = prepared.run.start_offset_s;
  options.true_anchors = anchorsTruthOf(robot.rawlog).anchors;
  OfflineRunHooks hooks;
  hooks.log = [&](LogLevel level, const std::string& text) {
    log(level, "robot " + robot.name + ": " + text);
  };
  hooks.progress = progress;
  hooks.stop = interrupted;
  const ResultsFolder own(folder.file(robot.name));
  const RunSummary summary = runOffline(estimator, options, own, hooks);
  writeTextFile(own.file("summary.json"), toJson(summary));
  if (summary.poses == 0) {
    const std::string& why = summary.longest_wait_reason;
    hooks.log(LogLevel::error, "no pose at all" + (why.empty() ? "" : ": " + why));
  }
  record.landmarks = estimator.landmarks();
  record.keyframes = estimator.keyframes();
  record.truth = groundTruthOf(robot.rawlog);
  return record;
}

}  // namespace vir::app
