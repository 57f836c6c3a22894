/// What the documentation and `--help` tell people to type works: each command is run as it stands,
/// in a folder where the recordings that it names are.
#include <gtest/gtest.h>

#include <cctype>
#include <filesystem>
#include <functional>
#include <map>
#include <opencv2/core.hpp>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "vir_test_docs.h"
#include "vir_test_pyfg.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"
#include "vir_test_video.h"

namespace vir {
namespace {

namespace fs = std::filesystem;

/// A command, the page or help that has it, and why it isn't run (empty: it is).
struct Typed {
  std::string where, command;
};

/// Not run, by how they begin, and where the same is tested instead.
const std::map<std::string, std::string> kNotRun{
    {"batch ini/benchmark.ini", "hours: batch_cli, shipped_ini"},
    {"batch mine.ini --out /scratch", "needs a cluster: slurm_cli"},
    {"--plugin-dir BUILD", "needs a build of the example: install"},
    {"REQUIRED COMPONENTS", "a line of CMake: install"},
    {"record robot.ini --out flight.rawlog --view", "needs a display: record_cli"},
    {"run my.rawlog --foxglove", "waits for who looks on: foxglove_cli"},
    {"run mh01.rawlog --foxglove", "likewise"},
    {"run FILE --foxglove", "likewise"},
    {"import csv FOLDER --topic imu=FILE --topic camera=LIST", "a form to fill in: csv"},
    {"import flight.mcap --out flight.rawlog --topic", "topics of somebody's: bag_import"},
    {"rendezvous ini/two_robots.ini --rawlog spiri:3=", "numbers of robots: rendezvous_cli"},
    {"import [DRIVER] SOURCE", "a form to fill in"},
    {"import pyfg FILE", "a form to fill in"},
    {"import FOLDER --calibration FILE", "a form to fill in"},
    {"import euroc FOLDER", "part of a command"},
    {"calibrate uwb", "the name of a command"},
    {"calibrate camera", "the name of a command"},
    {"run INI", "a form to fill in"},
    {"record INI", "a form to fill in"},
    {"batch INI", "a form to fill in"},
};
/// Other than 0: what these say of the made-up recordings.
const std::map<std::string, int> kCodes{
    // No display: it says so.
    {"view results/my", 1},
    {"run my.rawlog --view", 1},
    {"view results/flight", 1},
    {"view flight.rawlog --speed 4", 1},
};

/// What the pages leave open.
const std::map<std::string, std::string> kOpen{
    {"FOLDER", "MH_01_easy"}, {"SOURCE", "flight.bag"}, {"RECORDING", "flight.rawlog"},
    {"DRIVER", "euroc"},      {"COMMAND", "run"},       {"X", "mh01.rawlog"},
};

/// The examples that `vir-slam COMMAND --help` opens with.
std::vector<std::string> examplesOf(const std::string& command) {
  std::string help = test::virSlam(command + " --help").text;
  help = std::regex_replace(help, std::regex("\\\\\n *"), " ");
  std::vector<std::string> out;
  const std::regex line("\n  vir-slam ([^\n]*)");
  const std::string examples = help.substr(0, help.find("Usage:"));
  for (std::sregex_iterator i(examples.begin(), examples.end(), line), end; i != end; ++i) {
    const std::string text = (*i)[1];
    out.push_back(text.substr(0, text.find("   ")));
  }
  return out;
}

std::vector<Typed> everyCommand() {
  std::vector<Typed> out;
  std::set<std::string> known;
  const auto add = [&](const std::string& where, const std::string& text) {
    std::string command;
    for (const std::string& word : test::wordsIn(text)) command += " " + word;
    // One word alone names a command in a sentence.
    if (test::wordsIn(command).size() < 2 || !known.insert(command).second) return;
    out.push_back({where, command.substr(1)});
  };
  for (const fs::path& page : test::pages()) {
    for (const std::string& c : test::commandsIn(test::readText(page))) add(page.filename(), c);
  }
  for (const char* name :
       {"import", "check", "run", "calibrate camera", "calibrate uwb", "simulate", "record",
        "rendezvous", "evaluate", "batch", "export", "view", "map", "plugins"}) {
    for (const std::string& c : examplesOf(name)) add(std::string(name) + " --help", c);
  }
  return out;
}

/// A folder in which the files that commands name come to be when they are asked for.
class Desk {
 public:
  Desk() {
    for (const char* name : {"ini", "rawlog"}) {
      fs::copy(test::sourceRoot() / name, folder_ / name, fs::copy_options::recursive);
    }
    // The robots of the sample, for less time, in the light and with less to draw.
    change("simulate_two_robots.ini", "duration_s = 28", "duration_s = 16");
    change("simulate_two_robots.ini", "dark_s = 14 16.5", "dark_s =");
    change("live_replay.ini", "driver = RawlogReplay", "driver = RawlogReplay\nspeed = 4");
    make(
        "simulate ini/simulate_two_robots.ini --out kept/two.rawlog --set simulator.images=embed"
        " --set Camera.width_px=376 --set Camera.height_px=240 --set Camera.fx_px=229.3"
        " --set Camera.fy_px=228.6 --set Camera.cx_px=183.6 --set Camera.cy_px=124.2");
    make(
        "simulate --out kept/odom.rawlog --set simulator.images=none --set simulator.odometry=true"
        " --set 'SimulatedRanges.anchor_m=2 3 2' --set Robot_A.duration_s=30");
    make("run kept/two_A.rawlog --out kept/run");
    make("run kept/two_B.rawlog --out kept/run_b");
    make("export kept/two_A.rawlog --format mcap --out kept/flight.mcap");
    make("export kept/two_A.rawlog --format euroc --out kept/euroc");
    make("export kept/two_A.rawlog --format tum --out kept/tum");
  }

  /// Puts down what `command` reads, takes away what it would write, and runs it.
  test::Outcome run(const std::string& command) {
    std::vector<std::string> words = test::wordsIn(command);
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (kOpen.count(words[i]) > 0) words[i] = kOpen.at(words[i]);
      const bool written = i > 0 && (words[i - 1] == "--out" || words[i - 1] == "--json" ||
                                     words[i - 1] == "--plot" || words[i - 1] == "--video" ||
                                     words[i - 1] == "--save-map");
      if (written) {
        fs::remove_all(folder_ / words[i]);
        const fs::path written_to = words[i];
        if (written_to.extension() == ".rawlog") {
          fs::remove_all(folder_ / (fs::path(written_to).replace_extension().string() + "_Images"));
        }
      } else {
        provide(
            words[i].substr(words[i].find('=') == std::string::npos ? 0 : words[i].find('=') + 1));
      }
    }
    std::string line;
    for (const std::string& w : words) line += " " + w;
    return inFolder(line);
  }

  /// Takes away what the commands of a page have left.
  void clear() {
    for (const auto& item : fs::directory_iterator(folder_.path())) {
      const std::string name = item.path().filename();
      if (name != "kept" && name != "ini" && name != "rawlog") fs::remove_all(item.path());
    }
  }

 private:
  test::Outcome inFolder(const std::string& arguments) {
    return test::shell("cd " + test::quoted(folder_.path().string()) +
                       " && unset DISPLAY WAYLAND_DISPLAY && exec timeout 600 " +
                       test::quoted(test::buildDir() + "/bin/vir-slam") + " " + arguments);
  }
  void change(const std::string& ini, const std::string& from, const std::string& to) {
    const fs::path file = folder_ / "ini" / ini;
    const std::string text = test::readText(file);
    if (!test::contains(text, from)) throw std::runtime_error(ini + " has no " + from);
    test::writeText(file, std::regex_replace(text, std::regex(from), to));
  }
  void make(const std::string& arguments) {
    const test::Outcome o = inFolder(arguments);
    const bool made = o.code == 0;
    if (!made) throw std::runtime_error("cannot make " + arguments + ": " + o.text);
  }
  /// The recording, table or ini of this name, if it is one that commands read.
  void provide(const std::string& name);
  bool provideFolder(const fs::path& name);
  bool provideTable(const fs::path& name);
  void put(const std::string& kept, const fs::path& name) {
    const fs::path to = folder_ / name;
    fs::remove_all(to);
    fs::create_directories(to.parent_path().empty() ? to : to.parent_path());
    fs::copy(folder_ / "kept" / kept, to, fs::copy_options::recursive);
  }

  test::TempFolder folder_;
};

/// The calibration of the simulated camera as Kalibr writes it.
const char* const kKalibr = R"(cam0:
  T_cam_imu:
  - [0.0, -1.0, 0.0, 0.02]
  - [0.0, 0.0, -1.0, -0.01]
  - [1.0, 0.0, 0.0, -0.05]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 0.0002, 0.00002]
  distortion_model: radtan
  intrinsics: [229.3, 228.6, 183.6, 124.2]
  resolution: [376, 240]
  rostopic: /cam0/image_raw
  timeshift_cam_imu: 0.0
)";

/// The ini that a page shows as an example, from the line `first` on.
std::string iniOf(const std::string& page, const std::string& first) {
  std::istringstream in(test::readText(test::sourceRoot() / "docs" / page));
  std::string out;
  for (std::string line; std::getline(in, line);) {
    const bool code = line.rfind("    ", 0) == 0;
    if (out.empty() ? line != "    " + first : !code && !line.empty()) {
      if (!out.empty()) break;
      continue;
    }
    out += line.substr(code ? 4 : 0) + "\n";
  }
  return out;
}

bool Desk::provideFolder(const fs::path& name) {
  static const std::set<std::string> recordings{"MH_01_easy", "V1_02", "room1", "flight", "mav0"};
  const std::string first = name.begin()->string();
  if (name.parent_path() == "results")
    return put(name == "results/b" ? "run_b" : "run", name), true;
  if (first == "results" && !fs::exists(folder_ / name.parent_path())) {
    return put("run", name.parent_path()), true;
  }
  if (recordings.count(first) == 0) return false;
  return put(first == "mav0" ? "euroc/mav0" : "euroc", first), true;
}

bool Desk::provideTable(const fs::path& name) {
  const std::string e = name.extension(), stem = name.stem();
  const fs::path to = folder_ / name;
  if (e == ".tum") return put("tum/GT.tum", name), true;
  if (stem == "imu") return put("euroc/mav0/imu0/data.csv", name), true;
  if (stem == "vicon") return put("euroc/mav0/state_groundtruth_estimate0/data.csv", name), true;
  if (stem == "trajectory" || stem == "leica") return put("tum/GT.tum", name), true;
  if (e == ".csv") return test::writeText(to, "id,x,y,z,sigma\n0,2,3,2,0.1\n"), true;
  return false;
}

void Desk::provide(const std::string& name) {
  const fs::path to = folder_ / name, file = name;
  if (name.empty() || name[0] == '-' || fs::exists(to)) return;
  const std::string e = file.extension(), stem = file.stem();
  if (provideFolder(file)) return;
  if (e == ".rawlog") {
    const std::string kept = stem == "robot_a"              ? "odom"
                             : stem == "b" || stem == "two" ? "two_B"
                                                            : "two_A";
    put(kept + ".rawlog", name);
    put(kept + ".ini", fs::path(file).replace_extension(".ini"));
  } else if (e == ".bag" || e == ".mcap") {
    put("flight.mcap", name);  // what a file is tells its content, not its name
  } else if (e == ".yaml") {
    test::writeText(to, kKalibr);
  } else if (e == ".virmap") {
    make("run kept/two_A.rawlog --out kept/mapped --save-map " + name);
  } else if (e == ".pyfg") {
    test::writeText(to, test::twoRobots());
  } else if (e == ".mp4") {
    test::writeVideo(to, 320, 20, "mp4v", {376, 240});
  } else if (name == "mine.ini") {
    test::writeText(to, iniOf("cluster.md", "[Batch]"));
    for (const char* used : {"hall.rawlog", "yard.rawlog"}) provide(used);
    fs::copy(folder_ / "ini/euroc.ini", folder_ / "euroc.ini");
  } else if (name == "robot.ini") {
    const std::regex path("\\.\\./rawlog/two_A\\.rawlog");
    const std::string ini = test::readText(folder_ / "ini/live_replay.ini");
    test::writeText(to, std::regex_replace(ini, path, "kept/two_A.rawlog"));
  } else {
    provideTable(file);
  }
}

/// Which of `kNotRun` this is, if any. Parts of commands are so only as they stand, the others
/// whatever follows.
std::string reasonToLeave(const std::string& command) {
  for (const auto& [text, why] : kNotRun) {
    const bool whole = test::contains(why, "of a command");
    if (whole ? command == text : command.rfind(text, 0) == 0) return text;
  }
  return "";
}

int codeOf(const std::string& command) {
  const auto at = kCodes.find(command);
  return at == kCodes.end() ? 0 : at->second;
}

TEST(DocsCommands, Work) {
  Desk desk;
  std::string page;
  std::set<std::string> not_run, other_codes;
  long ran = 0;
  for (const Typed& t : everyCommand()) {
    const std::string left = reasonToLeave(t.command);
    if (!left.empty()) {
      not_run.insert(left);
      continue;
    }
    if (page != t.where) desk.clear();
    page = t.where;
    const test::Outcome o = desk.run(t.command);
    EXPECT_EQ(o.code, codeOf(t.command)) << t.where << ": vir-slam " << t.command << "\n" << o.text;
    if (kCodes.count(t.command) > 0) other_codes.insert(t.command);
    ++ran;
  }
  EXPECT_GT(ran, 90) << "the pattern finds what it should";
  // What no page has any more needs no exception.
  for (const auto& [text, why] : kNotRun) EXPECT_EQ(not_run.count(text), 1u) << text;
  for (const auto& [text, code] : kCodes) EXPECT_EQ(other_codes.count(text), 1u) << text;
}

}  // namespace
}  // namespace vir
