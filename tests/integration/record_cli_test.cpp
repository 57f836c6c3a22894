/// vir-slam record with the sample recording played as if live.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationImage.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir_test_paths.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using test::contains;
using test::quoted;
namespace fs = std::filesystem;

const std::string kIni = test::sourceDir() + "/ini/live_replay.ini";
const std::string kSample = test::sourceDir() + "/rawlog/two_A.rawlog";

struct Content {
  std::map<std::string, long> count;
  TimeNs first = 0, last = 0;
  bool sorted = true;
  long images_missing = 0;
  std::string damage;
};

Content contentOf(const std::string& rawlog) {
  Content out;
  rawlog::RawlogReader reader(rawlog);
  while (const auto o = reader.next()) {
    const TimeNs t = rawlog::fromMrptTime(o->timestamp);
    if (out.first == 0) out.first = t;
    out.sorted = out.sorted && t >= out.last;
    out.last = t;
    ++out.count[o->sensorLabel];
    const auto image = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(o);
    if (!image) continue;
    image->load();
    out.images_missing += image->image.isEmpty() ? 1 : 0;
  }
  out.damage = reader.damage();
  return out;
}

std::string faster(int times) {
  std::string out;
  for (const char* sensor : {"camera", "imu", "uwb", "truth"}) {
    out += " --set replay_" + std::string(sensor) + ".speed=" + std::to_string(times);
  }
  return out;
}

TEST(RecordCli, LosesNothing) {
  const test::TempFolder folder;
  const std::string out = (folder / "a.rawlog").string();
  const test::Outcome outcome = test::virSlam("record " + quoted(kIni) + " --out " + quoted(out) +
                                              " --set Recording.estimate=false" + faster(8));
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  const Content source = contentOf(kSample), copy = contentOf(out);
  // On a machine that does much else, a player can be later than the order of time waits.
  std::map<std::string, long> count = copy.count;
  const std::string late = (folder / "a_late.rawlog").string();
  if (fs::exists(late)) {
    for (const auto& [label, n] : contentOf(late).count) count[label] += n;
  }
  EXPECT_EQ(count, source.count);
  EXPECT_TRUE(copy.sorted);
  EXPECT_EQ(copy.first, source.first);
  EXPECT_EQ(copy.last, source.last);
  EXPECT_EQ(copy.images_missing, 0);
  EXPECT_EQ(copy.damage, "");
  EXPECT_TRUE(contains(outcome.text, "0 lost")) << outcome.text;
  // What is there is not written over.
  const test::Outcome again = test::virSlam("record " + quoted(kIni) + " --out " + quoted(out));
  EXPECT_EQ(again.code, 1);
  EXPECT_TRUE(contains(again.text, "exists already")) << again.text;
}

/// The program in the background.
class Background {
 public:
  Background(const std::string& arguments, const std::string& log) {
    pid_ = fork();
    if (pid_ == 0) {
      const std::string command = "exec " + quoted(test::buildDir() + "/bin/vir-slam") + " " +
                                  arguments + " > " + quoted(log) + " 2>&1";
      execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      _exit(127);
    }
    for (int i = 0; i < 3000 && !started(log); ++i) pause(0.01);
  }
  static void pause(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }
  /// Exit code, or -signal.
  int end(int signal) {
    kill(pid_, signal);
    int status = 0;
    waitpid(pid_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  static bool started(const std::string& log) {
    return fs::exists(log) && contains(test::readText(log), "recording 4 sensors");
  }
  pid_t pid_ = -1;
};

TEST(RecordCli, KilledItMissesLessThanASecond) {
  for (const double seconds : {1.3, 2.1, 3.37}) {
    const test::TempFolder folder;
    const std::string out = (folder / "a.rawlog").string();
    Background program(
        "record " + quoted(kIni) + " --out " + quoted(out) + " --set Recording.estimate=false",
        (folder / "log").string());
    Background::pause(seconds);
    EXPECT_EQ(program.end(SIGKILL), -SIGKILL);
    const Content content = contentOf(out);
    EXPECT_EQ(content.damage, "");
    EXPECT_TRUE(content.sorted);
    EXPECT_EQ(content.images_missing, 0);
    EXPECT_GT(toSeconds(content.last - content.first), seconds - 1);
    EXPECT_GE(content.count.size(), 6u);  // the other robot tells its anchor later
  }
}

TEST(RecordCli, EndsWellWhenItIsAskedTo) {
  const test::TempFolder folder;
  const std::string out = (folder / "a.rawlog").string(), log = (folder / "log").string();
  Background program("record " + quoted(kIni) + " --out " + quoted(out) + " --results " +
                         quoted((folder / "results").string()),
                     log);
  Background::pause(6);
  EXPECT_EQ(program.end(SIGTERM), 0) << test::readText(log);
  const Content content = contentOf(out);
  EXPECT_EQ(content.damage, "");
  EXPECT_GT(toSeconds(content.last - content.first), 5);
  const auto summary = nlohmann::json::parse(test::readText(folder / "results/summary.json"));
  EXPECT_EQ(summary["frames"].get<long>() + summary["counters"]["images_dropped_late"].get<long>(),
            content.count.at("CAM0"));
  EXPECT_GT(summary["poses"].get<long>(), summary["frames"].get<long>() / 2);
  EXPECT_LT(summary["ate_posyaw_m"].get<double>(), 0.1);
  EXPECT_TRUE(contains(test::readText(log), "image to pose [ms]: median")) << test::readText(log);

  // The other robot is followed while recording, as in a run.
  ASSERT_EQ(summary["peers"].size(), 1u);
  EXPECT_GT(summary["peers"][0]["ranges"].get<long>(), 20);
  EXPECT_EQ(summary["peers"][0]["ranges_without_broadcast"], 0);
  EXPECT_TRUE(fs::exists(folder / "results/transforms.json"));

  // Two threads while recording, one afterwards: the same trajectory.
  if (summary["counters"]["images_dropped_late"] != 0) GTEST_SKIP() << "too slow to compare";
  const test::Outcome again =
      test::virSlam("run " + quoted((folder / "results/used.ini").string()) + " --rawlog " +
                    quoted(out) + " --out " + quoted((folder / "again").string()));
  ASSERT_EQ(again.code, 0) << again.text;
  const std::string live = test::readText(folder / "results/trajectory.tum");
  EXPECT_EQ(live, test::readText(folder / "again/trajectory.tum"));
}

TEST(RecordCli, TheEstimatorIsTheOneThatTheSensorsAreFor) {
  const test::TempFolder folder;
  test::writeText(folder / "world.ini",
                  "[simulator]\nodometry = true\n[Robot_A]\nflight = eight\nduration_s = 4\n"
                  "[SimulatedRanges]\nanchor_m = 3 2 2\n");
  const std::string source = (folder / "source.rawlog").string();
  const test::Outcome made = test::virSlam("simulate " + quoted((folder / "world.ini").string()) +
                                           " --out " + quoted(source));
  ASSERT_EQ(made.code, 0) << made.text;
  test::writeText(folder / "record.ini",
                  "[Recording]\nestimate = true\n"
                  "[wheels]\ndriver = RawlogReplay\nprocess_rate = 200\nrawlog = source.rawlog\n"
                  "labels = ODOM UWB0\nclock = keep\n");
  const test::Outcome outcome = test::virSlam("record " + quoted((folder / "record.ini").string()) +
                                              " --out " + quoted((folder / "a.rawlog").string()) +
                                              " --results " + quoted((folder / "out").string()));
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  const auto summary = nlohmann::json::parse(test::readText(folder / "out/summary.json"));
  EXPECT_EQ(summary["estimator"], "odometry");
  EXPECT_GT(summary["poses"].get<long>(), 20);
}

TEST(RecordCli, AMissingSensorIsAnErrorUnlessItIsOptional) {
  const test::TempFolder folder;
  const std::string out = (folder / "a.rawlog").string();
  const std::string call = "record " + quoted(kIni) + " --out " + quoted(out) +
                           " --duration-s 1 --set Recording.estimate=false "
                           "--set replay_uwb.rawlog=/nowhere.rawlog";
  const test::Outcome missing = test::virSlam(call);
  EXPECT_EQ(missing.code, 1);
  EXPECT_TRUE(contains(missing.text, "replay_uwb: there is no such rawlog")) << missing.text;
  EXPECT_FALSE(fs::exists(out));
  const test::Outcome without = test::virSlam(call + " --set replay_uwb.optional=true");
  EXPECT_EQ(without.code, 0) << without.text;
  EXPECT_GT(contentOf(out).count.at("IMU0"), 100);
  EXPECT_EQ(contentOf(out).count.count("UWB0"), 0u);
}

/// The sample's IMU and ranges by their drivers from emulated devices, its images in step.
std::string deviceIni(const test::TempFolder& folder, long start_s) {
  const std::string ignore = "rawlog-grabber-ignore = true\n";
  const auto replay = [&](const std::string& name, const std::string& label) {
    return "[" + name + "]\ndriver = RawlogReplay\nprocess_rate = 100\nrawlog = " + kSample +
           "\nlabels = " + label + "\nstamps = now\nstart_at_s = " + std::to_string(start_s) + "\n";
  };
  return "[Recording]\n" + ignore + "estimate = true\n[Estimator]\n" + ignore + "driver = vir\n" +
         replay("camera", "CAM0") + replay("truth", "GT") +
         "[device_imu]\ndriver = SerialImu\nprocess_rate = 500\nsensorLabel = IMU0\n"
         "protocol = binary\nport = " +
         (folder / "imu").string() +
         "\n[device_uwb]\ndriver = UwbSerial\nprocess_rate = 500\nsensorLabel = UWB0\n"
         "protocol = auto\nanchor_ids = 1\nantenna_m = 0.03 0 0.08\nstd_error_m = 0.05\nport = " +
         (folder / "uwb").string() + "\n";
}

/// Sections are the same whatever their case; with no setting of both that does no harm.
TEST(RecordCli, SettingsOfASensorAndOfTheEstimatorInOneSectionAreRefused) {
  const test::TempFolder folder;
  const std::string ini = (folder / "a.ini").string();
  const std::string sensor =
      "[imu]\ndriver = RawlogReplay\nprocess_rate = 100\nrawlog = " + std::string(kSample) +
      "\nlabels = IMU0\n";
  const std::string out = (folder / "a.rawlog").string();
  const std::string command = "record " + quoted(ini) + " --estimate --duration-s 0.5 --out " +
                              quoted(out) + " --results " + quoted((folder / "results").string());
  test::writeText(ini, sensor + "noise_scale = 2\n");
  const test::Outcome refused = test::virSlam(command);
  EXPECT_EQ(refused.code, 2) << refused.text;
  EXPECT_TRUE(contains(refused.text, "[Imu] is the estimator's")) << refused.text;
  EXPECT_FALSE(fs::exists(out));
  test::writeText(ini, sensor);
  const test::Outcome alone = test::virSlam(command);
  // Without images there is nothing to estimate, which is said; the recording is there.
  EXPECT_EQ(alone.code, 1) << alone.text;
  EXPECT_TRUE(contains(alone.text, "no pose was estimated")) << alone.text;
  EXPECT_TRUE(fs::exists(out));
}

TEST(RecordCli, NothingAtAllIsNoRecording) {
  const test::TempFolder folder;
  test::writeText(folder / "a.ini",
                  "[imu]\ndriver = SerialImu\nprocess_rate = 100\nprotocol = binary\nport = " +
                      (folder / "nothing").string() + "\nsensorLabel = IMU0\noptional = true\n");
  const test::Outcome outcome =
      test::virSlam("record " + quoted((folder / "a.ini").string()) + " --duration-s 1 --out " +
                    quoted((folder / "a.rawlog").string()));
  EXPECT_EQ(outcome.code, 1) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "nothing was recorded")) << outcome.text;
}

TEST(RecordCli, DevicesOnPortsAreRecordedWholeAndEstimatedWith) {
  const test::TempFolder folder;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const long start_s = std::chrono::duration_cast<std::chrono::seconds>(now).count() + 5;
  test::writeText(folder / "live.ini", deviceIni(folder, start_s));
  const std::string sent = (folder / "sent.json").string();
  const std::string emulate = quoted(test::buildDir() + "/bin/vir-device-emulator") + " " +
                              quoted(kSample) + " --uwb trek1000=" + (folder / "uwb").string() +
                              " --imu binary=" + (folder / "imu").string() +
                              " --range-labels UWB0 --start-at " + std::to_string(start_s) +
                              " --summary " + quoted(sent);
  const std::string out = (folder / "a.rawlog").string();
  const test::Outcome outcome = test::shell(
      emulate + " > /dev/null & for i in $(seq 100); do [ -e " + (folder / "uwb").string() +
      " ] && [ -e " + (folder / "imu").string() + " ] && break; sleep 0.05; done; " +
      quoted(test::buildDir() + "/bin/vir-slam") + " record " +
      quoted((folder / "live.ini").string()) + " --out " + quoted(out) + " --results " +
      quoted((folder / "results").string()) + " --duration-s 36; code=$?; wait; exit $code");
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  const auto counts = nlohmann::json::parse(test::readText(sent));
  const Content source = contentOf(kSample), copy = contentOf(out);
  EXPECT_EQ(copy.damage, "");
  EXPECT_TRUE(copy.sorted);
  EXPECT_EQ(counts["imu"]["sent"].get<long>(), source.count.at("IMU0"));
  // On a machine that is stuck for long, some go to the file of the late ones: nothing is lost.
  Content late;
  if (fs::exists(folder / "a_late.rawlog")) late = contentOf((folder / "a_late.rawlog").string());
  for (const char* label : {"IMU0", "UWB0", "CAM0", "GT"}) {
    EXPECT_EQ(copy.count.at(label) + late.count[label], source.count.at(label)) << label << "\n"
                                                                                << outcome.text;
  }
  EXPECT_EQ(counts["uwb"]["sent"].get<long>(), source.count.at("UWB0"));
  const auto summary = nlohmann::json::parse(test::readText(folder / "results/summary.json"));
  EXPECT_GT(summary["poses"].get<long>(), 500);
  // The clocks of camera and devices agree to a millisecond or two.
  EXPECT_LT(summary["ate_posyaw_m"].get<double>(), 0.4);
}

TEST(RecordCli, TheStockGrabberReadsTheSameIniAndPlugins) {
  const bool there = test::shell("command -v rawlog-grabber").code == 0;
  if (!there) {
    GTEST_SKIP() << "rawlog-grabber is not installed (package mrpt-apps)";
  }
  const test::TempFolder folder;
  // It has no way to say where paths are relative to, and its own name for the output.
  std::string ini = test::readText(kIni);
  for (std::size_t at = 0; (at = ini.find("../rawlog/", at)) != std::string::npos;) {
    ini.replace(at, 10, test::sourceDir() + "/rawlog/");
  }
  test::writeText(folder / "grab.ini",
                  "[global]\nrawlog_prefix = grabbed\nGRABBER_PERIOD_MS = 500\n" + ini);
  // A key ends it.
  const test::Outcome outcome = test::shell(
      "cd " + quoted(folder.path().string()) +
      " && (sleep 5; echo) | timeout 60 rawlog-grabber -p " +
      quoted(test::buildDir() + "/lib/vir-slam/plugins/libvir_plugin_replay.so") + " grab.ini");
  std::string grabbed;
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    if (entry.path().extension() == ".rawlog") grabbed = entry.path().string();
  }
  ASSERT_FALSE(grabbed.empty()) << outcome.text;
  // It writes down the names of the images it was handed, which are those of the sample.
  rawlog::allowImagesElsewhere(true);
  const Content content = contentOf(grabbed);
  rawlog::allowImagesElsewhere(false);
  EXPECT_GT(content.count.count("IMU0"), 0u) << outcome.text;
  EXPECT_GT(content.count.count("CAM0"), 0u) << outcome.text;
  EXPECT_GT(content.count.count("UWB0"), 0u) << outcome.text;
}

}  // namespace
}  // namespace vir
