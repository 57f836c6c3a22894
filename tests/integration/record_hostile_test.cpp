/// vir-slam record while somebody sets the clock, the machine sleeps, or a crowd comes to its port.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationComment.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <thread>

#include "vir/rawlog/convert.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir/rawlog/rawlog_writer.h"
#include "vir_test_clock.h"
#include "vir_test_free_port.h"
#include "vir_test_process.h"
#include "vir_test_rawlog.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using test::contains;
using test::kMs;
using test::quoted;
namespace fs = std::filesystem;

constexpr TimeNs kS = 1000 * kMs;

#ifdef VIR_SANITIZED
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

void pause(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }

/// Stamps by label, in the order of the file.
std::map<std::string, std::vector<TimeNs>> stampsOf(const fs::path& rawlog, long* notes) {
  std::map<std::string, std::vector<TimeNs>> out;
  if (!fs::exists(rawlog)) return out;
  rawlog::RawlogReader reader(rawlog.string());
  while (const auto o = reader.next()) {
    const bool note = dynamic_cast<const mrpt::obs::CObservationComment*>(o.get()) != nullptr;
    *notes += note ? 1 : 0;
    if (!note) out[o->sensorLabel].push_back(rawlog::fromMrptTime(o->timestamp));
  }
  EXPECT_EQ(reader.damage(), "");
  return out;
}

/// IMU at 200 Hz, ranges at 20 Hz.
std::string flight(const test::TempFolder& folder, int seconds) {
  const std::string file = (folder / "flight.rawlog").string();
  rawlog::RawlogWriter writer(file);
  for (int i = 0; i < seconds * 200; ++i) {
    const ImuSample still{test::kStart + 5 * kMs * i, Vec3::Zero(), Vec3(0, 0, 9.81)};
    writer.write(*rawlog::toObservation(still, "IMU0"));
    if (i % 10 == 5) writer.write(*test::rangeAt(test::kStart + 5 * kMs * i, 1));
  }
  writer.finish();
  return file;
}

class RecordOfDevices : public testing::Test {
 protected:
  std::string at(const char* name) const { return (folder_ / name).string(); }

  std::string ini() const {
    const std::string file = at("live.ini");
    test::writeText(file,
                    "[Recording]\nrawlog-grabber-ignore = true\n"
                    "[device_imu]\ndriver = SerialImu\nprocess_rate = 500\n"
                    "sensorLabel = IMU0\nprotocol = binary\nport = " +
                        at("imu") +
                        "\n[device_uwb]\ndriver = UwbSerial\nprocess_rate = 500\n"
                        "sensorLabel = UWB0\nprotocol = nlink\nport = " +
                        at("uwb") + "\n");
    return file;
  }

  std::future<test::Outcome> emulate(const std::string& flight) const {
    const std::string call = quoted(test::buildDir() + "/bin/vir-device-emulator") + " " +
                             quoted(flight) + " --imu binary=" + at("imu") +
                             " --uwb nlink=" + at("uwb") + " --summary " + at("sent.json");
    auto emulator = std::async(std::launch::async, [call] { return test::shell(call); });
    for (int i = 0; i < 400 && !(fs::exists(at("imu")) && fs::exists(at("uwb"))); ++i) pause(0.05);
    return emulator;
  }

  void waitForData(const std::string& rawlog) const {
    std::error_code none;
    for (int i = 0; i < 3000 && (fs::file_size(rawlog, none) < 5000 || none); ++i) pause(0.01);
  }

  test::TempFolder folder_;
};

/// Set back by an hour, 1957 of 2784 readings were once stamped 100 ns apart; set back by 0.4 s,
/// they had a hole of 3.8 s.
TEST_F(RecordOfDevices, AClockThatIsSetAndAMachineThatSleepsMoveNoStamp) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer has to be loaded first";
  auto emulator = emulate(flight(folder_, 12));
  test::SettableClock clock(at("clock"));
  test::Limits limits;
  limits.clock = clock.file();
  test::Process record({"record", ini(), "--out", at("a.rawlog")}, limits);
  waitForData(at("a.rawlog"));
  for (const double set_s : {-3600.0, -3600.4, 5.0}) {
    clock.setBy(set_s);
    pause(0.8);
  }
  clock.sleptFor(3);
  pause(0.8);
  clock.sleptFor(23);
  EXPECT_EQ(emulator.get().code, 0);
  record.send(SIGTERM);
  EXPECT_EQ(record.wait(), 0) << record.text();
  EXPECT_TRUE(contains(record.text(), " 0 lost")) << record.text();

  long notes = 0;
  auto stamps = stampsOf(at("a.rawlog"), &notes);
  const auto late = stampsOf(at("a_late.rawlog"), &notes);  // where the machine was stuck for long
  EXPECT_EQ(notes, 3) << record.text();
  const auto sent = nlohmann::json::parse(test::readText(at("sent.json")));
  for (const auto& [label, device] : {std::pair{"IMU0", "imu"}, {"UWB0", "uwb"}}) {
    std::vector<TimeNs>& all = stamps[label];
    if (late.count(label) > 0) {
      all.insert(all.end(), late.at(label).begin(), late.at(label).end());
      std::sort(all.begin(), all.end());
    }
    ASSERT_GT(all.size(), 100u) << label;
    ASSERT_EQ(static_cast<long>(all.size()), sent[device]["sent"].get<long>()) << record.text();
    const TimeNs period = label == std::string("IMU0") ? 5 * kMs : 50 * kMs;
    int holes = 0;
    TimeNs length = 0;
    for (std::size_t i = 1; i < all.size(); ++i) {
      const TimeNs step = all[i] - all[i - 1];
      const bool hole = step > kS;
      holes += hole ? 1 : 0;
      if (hole) {
        EXPECT_NEAR(toSeconds(step), holes == 1 ? 3 : 20, 1) << label;
      } else {
        length += step;
      }
    }
    EXPECT_EQ(holes, 2) << label << ": the sleeps";
    const TimeNs due = static_cast<TimeNs>(all.size() - 2) * period;
    EXPECT_NEAR(toSeconds(length), toSeconds(due), 0.5) << label;
  }
}

/// -1 if nobody listens.
int connectTo(int port) {
  const int handle = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(static_cast<std::uint16_t>(port));
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(handle, reinterpret_cast<sockaddr*>(&at), sizeof at) == 0) return handle;
  close(handle);
  return -1;
}

/// 1,301 idle clients once took the descriptors that the recording needed for its images, and ended
/// it. Here it has few, and the port may take more than there are.
TEST(RecordStream, ACrowdOfIdleClientsCostsTheRecordingNothing) {
  const test::TempFolder folder;
  const std::string source = test::sourceDir() + "/rawlog/two_A.rawlog";
  const int port = test::freePort();
  std::string call =
      "ulimit -n 80; " + quoted(test::buildDir() + "/bin/vir-slam") + " record " +
      quoted(test::sourceDir() + "/ini/live_replay.ini") + " --out " +
      quoted((folder / "a.rawlog").string()) + " --results " + quoted((folder / "r").string()) +
      " --set Recording.stream_clients=256 --set Recording.stream_port=" + std::to_string(port);
  for (const char* sensor : {"camera", "imu", "uwb", "truth"}) {
    call += " --set replay_" + std::string(sensor) + ".speed=4";
  }
  auto record = std::async(std::launch::async, [call] { return test::shell(call); });
  std::vector<int> crowd;
  for (int i = 0; i < 6000 && crowd.empty(); ++i) {
    const int handle = connectTo(port);
    if (handle >= 0) crowd.push_back(handle);
    pause(0.01);
  }
  ASSERT_EQ(crowd.size(), 1u) << record.get().text;
  for (int i = 1; i < 400; ++i) crowd.push_back(connectTo(port));
  EXPECT_EQ(std::count(crowd.begin(), crowd.end(), -1), 0);
  const test::Outcome outcome = record.get();
  for (const int handle : crowd) close(handle);
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, " 0 lost")) << outcome.text;
  // Of 80 descriptors 32 stay free, and the program has some 20 of its own.
  std::smatch away;
  ASSERT_TRUE(std::regex_search(outcome.text, away, std::regex("(\\d+) were sent away")));
  EXPECT_GE(std::stol(away[1]), 400 - 48) << outcome.text;
  long notes = 0;
  const auto given = stampsOf(source, &notes), got = stampsOf(folder / "a.rawlog", &notes),
             late = stampsOf(folder / "a_late.rawlog", &notes);
  for (const auto& [label, all] : given) {
    const std::size_t aside = late.count(label) > 0 ? late.at(label).size() : 0;
    EXPECT_EQ(got.at(label).size() + aside, all.size()) << label << "\n" << outcome.text;
  }
}

}  // namespace
}  // namespace vir
