#pragma once
/// What the faults happen to: each command that works for a while, with inputs of its own.
#include <functional>
#include <string>
#include <vector>

#include "vir_test_euroc_folder.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {

/// Inputs, made once.
class FaultInputs {
 public:
  FaultInputs() {
    test::writeText(folder_ / "world.ini",
                    "[simulator]\nrobots = A B\ntracks = true\n[Robot_A]\nflight = eight\n"
                    "duration_s = 9\n[Robot_B]\nflight = letter_s\nduration_s = 9\n"
                    "start_m = 2 -3 0.4\n[SimulatedRanges]\nanchor_m = 3 2 2\n");
    test::writeText(folder_ / "one.ini",
                    "[simulator]\ntracks = true\n[Robot_A]\nflight = eight\nduration_s = 9\n");
    test::writeText(folder_ / "run.ini", "[Estimator]\ndriver = vir\n");
    test::writeText(folder_ / "two.ini",
                    "[Estimator]\ndriver = vir\n[Rendezvous]\ndriver = nlopt\n");
    test::writeText(folder_ / "plan.ini",
                    "[Batch]\nsequences = eight mine\nconditions = clean\nseeds = 0\n"
                    "ini = run.ini\nsettings = on\n[Sequence_eight]\nworld = one.ini\n"
                    "[Sequence_mine]\nrawlog = w_A.rawlog\n[Condition_clean]\n"
                    "simulator.robots = A\n[Setting_on]\n");
    const std::string ignore = "rawlog-grabber-ignore = true\n";
    std::string live =
        "[Recording]\n" + ignore + "estimate = true\n[Estimator]\n" + ignore + "driver = vir\n";
    for (const std::string label : {"TRACKS0", "IMU0", "UWB0", "GT"}) {
      live += "[replay_" + label + "]\ndriver = RawlogReplay\nprocess_rate = 200\n" +
              "rawlog = w_A.rawlog\nspeed = 2\nclock = keep\nlabels = " + label + "\n";
    }
    test::writeText(folder_ / "live.ini", live);
    made_ = test::virSlam("simulate " + test::quoted(at("world.ini")) + " --out " +
                          test::quoted(at("w.rawlog")));
    if (made_.code == 0) std::filesystem::copy_file(at("w_A.rawlog"), at("whole.rawlog"));
  }
  const test::Outcome& made() const { return made_; }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  std::string euroc() const { return euroc_.root().string(); }

  /// Half of what commands read, or none of it, is gone.
  void takeRecording() const {
    std::filesystem::resize_file(at("w_A.rawlog"),
                                 std::filesystem::file_size(at("w_A.rawlog")) / 2);
  }
  void giveRecording() const {
    std::filesystem::copy_file(at("whole.rawlog"), at("w_A.rawlog"),
                               std::filesystem::copy_options::overwrite_existing);
  }
  void takeImages() const {
    std::filesystem::rename(euroc_.mav0() / "cam0", euroc_.mav0() / "gone");
  }
  void giveImages() const {
    std::filesystem::rename(euroc_.mav0() / "gone", euroc_.mav0() / "cam0");
  }

 private:
  static test::EurocFolderOptions manyImages() {
    test::EurocFolderOptions o;
    o.images = 400;
    return o;
  }
  test::TempFolder folder_;
  test::EurocFolder euroc_{manyImages()};
  test::Outcome made_;
};

inline const FaultInputs& faultInputs() {
  static const FaultInputs made;
  return made;
}

/// One command and what is particular to it.
struct FaultCommand {
  std::string name;    ///< as the tests call it
  std::string column;  ///< of the table in docs/faults.md
  std::function<std::vector<std::string>(const std::string& out)> arguments;
  std::string said_when_asked;      ///< to end
  bool results_when_asked = false;  ///< summary.json is there then
  std::function<void()> take_input, give_input;
};

inline std::vector<FaultCommand> faultCommands() {
  const FaultInputs& in = faultInputs();
  const auto take = [&in] { in.takeRecording(); };
  const auto give = [&in] { in.giveRecording(); };
  const auto one = [&in](const std::string& command, const std::string& input, const char* name,
                         const std::vector<std::string>& more) {
    return [=, &in](const std::string& out) {
      std::vector<std::string> all{command, in.at(input), "--out", out + "/" + name};
      all.insert(all.end(), more.begin(), more.end());
      return all;
    };
  };
  std::vector<FaultCommand> all;
  all.push_back({"simulate", "simulate", one("simulate", "world.ini", "x.rawlog", {}),
                 "interrupted; no rawlog was written", false, nullptr, nullptr});
  all.push_back({"import", "import",
                 [&in](const std::string& out) {
                   return std::vector<std::string>{
                       "import",          "euroc", in.euroc(),          "--out",
                       out + "/x.rawlog", "--set", "euroc.images=embed"};
                 },
                 "interrupted; no rawlog was written", false, [&in] { in.takeImages(); },
                 [&in] { in.giveImages(); }});
  all.push_back({"run", "run", one("run", "run.ini", "r", {"--rawlog", in.at("w_A.rawlog")}),
                 "interrupted", true, take, give});
  all.push_back({"record", "record",
                 [&in](const std::string& out) {
                   // A recording is never written over: each has its own name.
                   static int n = 0;
                   const std::string name = out + "/x" + std::to_string(++n) + ".rawlog";
                   return std::vector<std::string>{
                       "record",    in.at("live.ini"), "--out",        name,
                       "--results", out + "/r",        "--duration-s", "2.5"};
                 },
                 "wrote ", true, take, give});
  all.push_back(
      {"batch", "batch", one("batch", "plan.ini", "b", {}), "interrupted", false, take, give});
  all.push_back(
      {"rendezvous", "rendezvous",
       one("rendezvous", "two.ini", "r",
           {"--rawlog", "A=" + in.at("w_A.rawlog"), "--rawlog", "B=" + in.at("w_B.rawlog")}),
       "", true, take, give});
  for (const std::string format : {"csv", "mcap"}) {
    all.push_back(
        {"export_" + format, "export",
         one("export", "w_A.rawlog", format == "csv" ? "c" : "c.mcap", {"--format", format}),
         "interrupted; nothing was exported", false, take, give});
  }
  return all;
}

}  // namespace vir
