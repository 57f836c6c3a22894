#include "robots/rendezvous_robots.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "output/console.h"
#include "output/run_folder.h"
#include "recordings/companion.h"
#include "robots/common_places.h"
#include "robots/robot_recorder.h"
#include "setup/auto_driver.h"
#include "setup/prepared_run.h"
#include "vir/core/ini_writer.h"
#include "vir/core/parse_number.h"
#include "vir/roles/estimator_registry.h"
#include "vir/roles/rendezvous_registry.h"
#include "vir/runs/offline_run.h"

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
    if (!parseNumber(text.substr(colon + 1), &robot.id)) {
      throw UsageError("'" + text + "': behind the colon stands the robot's id, a whole number");
    }
  } else if (robot.name.size() == 1 && std::isalpha(static_cast<unsigned char>(robot.name[0]))) {
    robot.id = std::toupper(static_cast<unsigned char>(robot.name[0])) - 'A';
  } else {
    robot.id = static_cast<int>(place);
  }
  return robot;
}

/// NAME=REST of an option.
std::pair<std::string, std::string> named(const std::string& option, const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos) {
    throw UsageError(option + " " + text + ": write NAME=FILE or NAME:ID=FILE");
  }
  return {text.substr(0, equals), text.substr(equals + 1)};
}

/// NAME=FILE of an option, for robots that there are.
std::map<std::string, std::string> filesOf(const std::string& option,
                                           const std::vector<std::string>& texts,
                                           const std::set<std::string>& names) {
  std::map<std::string, std::string> out;
  for (const std::string& text : texts) {
    const auto [name, file] = named(option, text);
    if (names.count(name) == 0) throw UsageError(option + " " + text + ": no robot " + name);
    out[name] = file;
  }
  return out;
}

/// A finished run says which recording it is of; that may have been moved since.
void findRecording(const std::map<std::string, std::string>& given, RobotFile* robot) {
  const auto ranges = given.find(robot->name);
  if (!fs::is_directory(robot->rawlog)) {
    if (ranges != given.end()) {
      throw UsageError("--ranges " + robot->name + "=...: " + robot->rawlog +
                       " is a recording itself, not a finished run");
    }
    return;
  }
  const RunFolder folder = openRunFolder(robot->rawlog);
  robot->finished = folder.path;
  robot->rawlog = ranges != given.end() ? ranges->second : folder.rawlog;
  if (ranges != given.end() || fs::is_regular_file(robot->rawlog)) return;
  // The path was relative to where the program ran then: perhaps to the folder's surroundings.
  for (fs::path up = fs::absolute(folder.path).parent_path(); up != up.root_path();
       up = up.parent_path()) {
    if (folder.rawlog.empty() || fs::path(folder.rawlog).is_absolute()) break;
    if (!fs::is_regular_file(up / folder.rawlog)) continue;
    robot->rawlog = (up / folder.rawlog).string();
    return;
  }
  throw UsageError("the mutual ranges of robot " + robot->name + " are in the recording that " +
                   folder.path + " was made from" +
                   (folder.rawlog.empty() ? ", and its summary.json does not name it"
                                          : ", and " + folder.rawlog + " is not there") +
                   ": give it with --ranges " + robot->name + "=FILE");
}

std::vector<RobotFile> robotFiles(const Settings& settings, const RobotArguments& arguments) {
  std::vector<RobotFile> robots;
  for (const std::string& text : arguments.rawlogs) {
    const auto [name, file] = named("--rawlog", text);
    robots.push_back(robotOf(name, file, robots.size()));
  }
  if (robots.empty() && settings.hasSection(kRobotsSection)) {
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
        (settings.name().empty() ? "an ini" : settings.name()));
  }
  std::set<std::string> names;
  std::set<int> ids;
  for (const RobotFile& r : robots) {
    if (!names.insert(r.name).second) throw UsageError("two robots are called " + r.name);
    if (!ids.insert(r.id).second) {
      throw UsageError("two robots have the id " + std::to_string(r.id) +
                       ": give them with NAME:ID=FILE");
    }
  }
  const auto ranges = filesOf("--ranges", arguments.ranges, names);
  const auto maps = filesOf("--map", arguments.maps, names);
  for (RobotFile& r : robots) {
    findRecording(ranges, &r);
    requireFile(r.rawlog, "rawlog");
    const auto map = maps.find(r.name);
    const std::string given = map == maps.end() ? "" : map->second;
    if (!r.finished.empty()) {
      r.map = mapOfFinished(given, r.finished);
    } else if (!given.empty()) {
      throw UsageError("--map " + r.name + "=...: robot " + r.name +
                       " is estimated here, and its map made by that");
    }
  }
  return robots;
}

/// Reads every setting of a robot's run; throws SettingsError for what nobody knows. No estimator
/// for a finished run.
std::unique_ptr<roles::EstimatorSettings> configured(const Prepared& p, const RobotFile& robot,
                                                     OptionVisitor* also) {
  SettingsReader reader(robot.settings);
  reader.ignoreSection(kRobotsSection);
  RunOptions run;
  RendezvousRunOptions rendezvous;
  describe(reader, run);
  std::unique_ptr<roles::EstimatorSettings> estimator;
  const bool finished = !robot.finished.empty();
  if (!finished) {
    estimator = roles::estimatorSettings(robot.driver);
    estimator->describe(reader);
  } else if (p.run.driver != kAutoDriver) {
    roles::estimatorSettings(p.run.driver)->describe(reader);
  }
  acceptOtherDrivers(p.run.driver, robot.driver, &reader);
  describe(reader, rendezvous);
  const auto solver = roles::createRendezvous(p.rendezvous.driver);
  solver->describe(reader);
  team::JointOptions joint;
  team::describe(reader, joint);
  reader.ignoreUnknownFrom(robot.companion);
  reader.finish();
  if (also != nullptr) {
    describe(*also, run);
    if (estimator) estimator->describe(*also);
    describe(*also, rendezvous);
    solver->describe(*also);
    team::describe(*also, joint);
  }
  return estimator;
}

team::RobotRecord finishedRobot(const Prepared& prepared, const RobotFile& robot,
                                const LogSink& log) {
  team::RobotRecord record;
  readRunFolder({robot.finished, robot.rawlog}, &record);
  readRecording(robot.rawlog, prepared.rendezvous.peer_label, &record);
  vir::log(log, LogLevel::info,
           "robot " + robot.name + ": " + std::to_string(record.poses.size()) + " poses from " +
               robot.finished + ", ranges from " + robot.rawlog);
  return record;
}

}  // namespace

std::unique_ptr<roles::Rendezvous> Prepared::createSolver(const LogSink& log) const {
  auto solver = roles::createRendezvous(rendezvous.driver);
  SettingsReader reader(settings);
  solver->describe(reader);
  solver->start(log);
  return solver;
}

Prepared prepareRobots(const RobotArguments& arguments, const Common& common) {
  Prepared out;
  if (!arguments.ini.empty()) out.settings = Settings::fromFile(arguments.ini);
  out.calibration = takeCalibration("", arguments.assignments, &out.settings);
  SettingsReader own(out.settings);
  describe(own, out.run);
  describe(own, out.rendezvous);
  team::describe(own, out.joint);
  out.robots = robotFiles(out.settings, arguments);
  loadPlugins(common, {roles::PluginRole::estimator, roles::PluginRole::rendezvous});
  for (std::size_t i = 0; i < out.robots.size(); ++i) {
    RobotFile& robot = out.robots[i];
    robot.settings = out.settings;
    robot.companion = companionOf(robot.rawlog);
    if (!robot.companion.empty()) {
      robot.settings.mergeDefaults(Settings::fromFile(robot.companion));
    }
    if (robot.finished.empty())
      robot.driver = driverFor(out.run.driver, robot.settings, robot.rawlog);
    IniWriter used(IniWriter::Style::values);
    configured(out, robot, i == 0 ? &used : nullptr);
    if (i == 0) out.used_ini = used.text();
  }
  return out;
}

namespace {

/// What a run of this robot alone would have as used.ini.
std::string ownSettings(const Prepared& prepared, const RobotFile& robot, RunOptions run) {
  const auto estimator = configured(prepared, robot, nullptr);
  IniWriter used(IniWriter::Style::values);
  describe(used, run);
  estimator->describe(used);
  return used.text();
}

team::RobotRecord estimatedRobot(const Prepared& prepared, RobotFile robot,
                                 const results::ResultsFolder& own,
                                 const runs::OfflineRunHooks& hooks) {
  team::RobotRecord record;
  if (prepared.rendezvous.use_places) {
    keepMap(ownSettings(prepared, robot, prepared.run), own, &robot);
  }
  const auto settings = configured(prepared, robot, nullptr);
  const auto estimator = settings->create(hooks.log);
  RobotRecorder recorder(&record);
  RunOptions run = prepared.run;
  run.driver = robot.driver;
  run.rawlog = robot.rawlog;
  runs::OfflineRunOptions options = offlineOptions(run, settings->inputs(), hooks.log);
  options.true_anchors = anchorsTruthOf(robot.rawlog).anchors;
  options.anchor_texts = anchorTextsOf(robot.rawlog);
  results::writeTextFile(own.file("used.ini"), ownSettings(prepared, robot, run));
  GivenCalibration calibration = prepared.calibration;
  calibration.setCameraLabel(imageLabel(options.inputs));
  runs::OfflineRunHooks observed = hooks;
  observed.prepare = [&](mrpt::obs::CObservation* o) { calibration.apply(o); };
  observed.observers.push_back(&recorder);
  const results::RunSummary summary = runs::runOffline(*estimator, options, own, observed);
  results::writeTextFile(own.file("summary.json"), toJson(summary));
  if (summary.poses == 0) {
    const std::string& why = summary.longest_wait_reason;
    hooks.log(LogLevel::error, "no pose at all" + (why.empty() ? "" : ": " + why));
  }
  readRecording(robot.rawlog, prepared.rendezvous.peer_label, &record);
  return record;
}

}  // namespace

team::RobotRecord runRobot(const Prepared& prepared, std::size_t i,
                           const results::ResultsFolder& folder, const LogSink& log,
                           const std::function<void(double)>& progress) {
  const RobotFile& robot = prepared.robots[i];
  team::RobotRecord record;
  if (robot.finished.empty()) {
    runs::OfflineRunHooks hooks;
    hooks.log = [&](LogLevel level, const std::string& text) {
      log(level, "robot " + robot.name + ": " + text);
    };
    hooks.progress = progress;
    hooks.stop = interrupted;
    record =
        estimatedRobot(prepared, robot, results::ResultsFolder(folder.file(robot.name)), hooks);
  } else {
    record = finishedRobot(prepared, robot, log);
  }
  record.name = robot.name;
  record.id = robot.id;
  return record;
}

}  // namespace vir::app
