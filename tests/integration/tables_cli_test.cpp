/// What `check`, `import` and `run` say of folders of tables that are not as they should be.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"
#include "vir_test_utf16.h"

namespace vir {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::Outcome;
using test::quoted;
using test::virSlam;

constexpr long long kStart = 1700000000000000000;

class Tables : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(root());
    imu("timestamp,gx,gy,gz,ax,ay,az\n", false);
    ranges("timestamp,anchor_id,range\n");
  }
  fs::path root() const { return folder_ / "r"; }
  std::string source() const { return quoted(root().string()); }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  void imu(const std::string& header, bool force_first) {
    std::string text = header;
    for (int i = 0; i < 600; ++i) {
      const double x = std::sin(0.1 * i), y = std::cos(0.07 * i);
      char gyro[80], acc[80], line[200];
      std::snprintf(gyro, sizeof gyro, "%.6f,%.6f,%.6f", 0.1 * x, 0.05 * y, 0.02 * x * x);
      std::snprintf(acc, sizeof acc, "%.6f,%.6f,%.6f", 0.1 * x, 0.1 * y, 9.81 + 0.01 * x);
      std::snprintf(line, sizeof line, "%lld,%s,%s\n", kStart + i * 5'000'000LL,
                    force_first ? acc : gyro, force_first ? gyro : acc);
      text += line;
    }
    test::writeText(root() / "imu.csv", text);
  }
  void ranges(const std::string& header) {
    std::string text = header;
    for (int i = 0; i < 180; ++i) {
      char line[80];
      std::snprintf(line, sizeof line, "%lld,%d,%.4f\n", kStart + i * 16'000'000LL, i % 3 + 1,
                    2 + i % 3 + 0.05 * std::sin(0.1 * i) + 0.01 * std::sin(7.3 * i));
      text += line;
    }
    test::writeText(root() / "uwb.csv", text);
  }
  void expect(const Outcome& outcome, int code, const std::string& part) const {
    EXPECT_EQ(outcome.code, code) << outcome.text;
    EXPECT_TRUE(contains(outcome.text, part)) << part << " is not in\n" << outcome.text;
  }

  test::TempFolder folder_;
};

TEST_F(Tables, GoodOnesAreFine) { expect(virSlam("check " + source()), 0, ": fine\n"); }

TEST_F(Tables, ColumnsTakenByPositionAreDoubtful) {
  ranges("Zeit,Anker,Weite [m]\n");
  const std::string said = "taken by position: Zeit as stamp, Anker as anchor, Weite [m] as range";
  const Outcome checked = virSlam("check " + source());
  expect(checked, 3, said);
  expect(checked, 3, "doubtful: file: names of columns are not known");
  const Outcome imported = virSlam("import " + source() + " --out " + quoted(file("a.rawlog")));
  expect(imported, 0, said);
  expect(imported, 0, "doubtful: file: names of columns are not known");
}

TEST_F(Tables, UnitsThatTellAreNoDoubt) {
  imu("Zeit,u [m/s^2],v [m/s^2],w [m/s^2],p [rad/s],q [rad/s],r [rad/s]\n", true);
  expect(virSlam("check " + source()), 0, "p [rad/s] as gyro x");
}

TEST_F(Tables, WhatIsThereAndOfNoUseIsDoubtful) {
  ranges("timestamp,anchor,quality\n");
  expect(virSlam("check " + source()), 3, "none could be used");
  expect(virSlam("import " + source() + " --out " + quoted(file("a.rawlog"))), 1,
         "its header names no anchor");
  test::writeText(root() / "uwb.csv", "");
  expect(virSlam("check " + source()), 3, "note: uwb.csv is empty; not read");
}

TEST_F(Tables, ATableOfNoPosesIsNamedWithTheReason) {
  test::writeText(root() / "vicon.csv", "time,roll,pitch\n1,2,3\n2,3,4\n3,4,5\n");
  expect(virSlam("check " + source()), 0, "its header names no x, y and z of a position");
}

TEST_F(Tables, CheckTakesTopics) {
  const Outcome outcome = virSlam("check " + source() + " --topic range=none");
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_FALSE(contains(outcome.text, "UWB0")) << outcome.text;
}

TEST_F(Tables, NamesInTopicsMayHaveBlanks) {
  fs::rename(root() / "imu.csv", root() / "my imu.csv");
  const Outcome outcome =
      virSlam("check " + source() + " --topic 'imu=my imu.csv' --topic range=none");
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "IMU0")) << outcome.text;
  expect(virSlam("check " + source() + " --topic 'imu=my imu.cs'"), 1, "there is no ");
}

TEST_F(Tables, AListOfImagesThatAreNotThereIsDoubtful) {
  test::writeText(root() / "CAM0.csv", "timestamp,filename\n" + std::to_string(kStart) +
                                           ",a.png\n" + std::to_string(kStart + 50'000'000) +
                                           ",b.png\n");
  const Outcome outcome = virSlam("check " + source());
  expect(outcome, 3, "CAM0.csv: taken for a list of images, but they are not there");
  expect(outcome, 3, "images are listed and not there");
}

TEST_F(Tables, AMinusIsNoFile) {
  expect(virSlam("check " + source() + " --json -"), 2, "'-' is no file");
  EXPECT_FALSE(fs::exists("-"));
}

TEST_F(Tables, SeveralFilesOfCalibration) {
  const std::string camera =
      "cam0:\n  camera_model: pinhole\n  intrinsics: [400, 400, 320, 240]\n"
      "  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [640, 480]\n"
      "  T_cam_imu: [[1,0,0,0.02],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n";
  std::string far = camera;
  far.replace(far.find("0.02"), 4, "5200");
  test::writeText(file("cam.yaml"), camera);
  test::writeText(file("far.yaml"), far);
  test::writeText(file("imu.yaml"),
                  "accelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\n"
                  "gyroscope_noise_density: 0.005\ngyroscope_random_walk: 4.0e-06\n");
  const auto with = [&](const std::string& a, const std::string& b) {
    return virSlam("check " + source() + " --calibration " + quoted(file(a)) + " --calibration " +
                   quoted(file(b)));
  };
  const Outcome both = with("cam.yaml", "imu.yaml");
  expect(both, 0, "its pose on the IMU, noise of the IMU go before what the recording says");
  expect(both, 0, "given 0.005 and 0.01");
  expect(with("cam.yaml", "far.yaml"), 2, "both hold cameras: give one of the two");
  expect(with("imu.yaml", "nowhere.yaml"), 2, "there is no such calibration: ");
  // Of a pose in millimetres.
  const Outcome distant = with("far.yaml", "imu.yaml");
  expect(distant, 0, "cam0: its pose on the IMU is 5200 m away from it");
  // Where the settings go to the driver.
  expect(
      virSlam("import " + source() + " --calibration " + quoted(file("cam.yaml")) +
              " --calibration " + quoted(file("imu.yaml")) + " --out " + quoted(file("b.rawlog"))),
      0, "wrote ");
}

TEST_F(Tables, WhatIsNotThereOrEmptyIsSaidFirst) {
  test::writeText(file("e.bag"), "");
  test::writeText(file("e.yaml"), "");
  for (const std::string command : {"run ", "view ", "import ", "check "}) {
    expect(virSlam(command + quoted(file("nothere.bag"))), 2,
           "there is no such file or folder: " + file("nothere.bag"));
    expect(virSlam(command + quoted(file("e.bag"))), 2, file("e.bag") + " is empty");
  }
  expect(virSlam("check " + source() + " --calibration " + quoted(file("e.yaml"))), 2,
         "the calibration is empty: ");
}

TEST_F(Tables, NamesOfAnchorsGoThroughExportAndBack) {
  const char* ids[] = {"9412036502",           "0x84",       "200A",      "0x1122334455667788",
                       "18446744073709551615", "north wall", "T\xc3\xbcr"};
  std::string text = "timestamp,anchor_id,range\n";
  for (int i = 0; i < 420; ++i) {
    char line[80];
    std::snprintf(line, sizeof line, "%lld,%s,%.4f\n", kStart + i * 9'000'000LL, ids[i % 7],
                  2 + i % 7 + 0.05 * std::sin(0.1 * i));
    text += line;
  }
  test::writeText(root() / "uwb.csv", text);
  const auto remarks = [](const std::string& ini) { return ini.substr(ini.find('\n')); };
  ASSERT_EQ(virSlam("import " + source() + " --out " + quoted(file("a.rawlog"))).code, 0);
  const std::string names = remarks(test::readText(file("a.ini")));
  EXPECT_EQ(names,
            "\n// anchor 1000002 is '0x1122334455667788'\n"
            "// anchor 1000003 is '18446744073709551615'\n"
            "// anchor 1000001 is '200A'\n// anchor 1000000 is '9412036502'\n"
            "// anchor 1000005 is 'T\xc3\xbcr'\n// anchor 1000004 is 'north wall'\n");
  for (const char* format : {"mcap", "csv"}) {
    const std::string out = file(std::string("e.") + format);
    ASSERT_EQ(virSlam("export " + quoted(file("a.rawlog")) + " --format " + format + " --out " +
                      quoted(out))
                  .code,
              0);
    const Outcome back = virSlam("import " + quoted(out) + " --out " + quoted(file("b.rawlog")));
    ASSERT_EQ(back.code, 0) << back.text;
    EXPECT_EQ(remarks(test::readText(file("b.ini"))), names) << format;
    // In findings they are called as in the recording, those that fit by their number.
    const Outcome checked = virSlam("check " + quoted(file("b.rawlog")));
    for (const char* id :
         {"9412036502", "132", "200A", "0x1122334455667788", "north wall", "T\xc3\xbcr"}) {
      EXPECT_TRUE(contains(checked.text, std::string("anchor ") + id + ": noise")) << checked.text;
    }
    fs::remove(file("b.rawlog"));
  }
}

TEST_F(Tables, TextInUtf16IsRead) {
  const auto rewrite = [](const fs::path& path, bool little) {
    test::writeText(path, test::utf16(test::readText(path), little));
  };
  const auto imported = [&](const std::string& name) {
    const Outcome o = virSlam("import " + source() + " --out " + quoted(file(name)));
    EXPECT_EQ(o.code, 0) << o.text;
    return test::readText(file(name));
  };
  const std::string as_it_was = imported("a.rawlog");
  for (const bool little : {true, false}) {
    rewrite(root() / "imu.csv", little);
    rewrite(root() / "uwb.csv", little);
    EXPECT_EQ(imported("b.rawlog") == as_it_was, true) << little;
    SetUp();
    fs::remove(file("b.rawlog"));
  }
  test::writeText(file("a.tum"), "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n3 1 1 0 0 0 0 1\n");
  test::writeText(file("u.tum"), test::utf16(test::readText(file("a.tum"))));
  expect(virSlam("evaluate --reference " + quoted(file("u.tum")) + " " + quoted(file("a.tum"))), 0,
         "3");
  // Settings and calibrations.
  test::writeText(file("u.ini"), test::utf16("[Estimator]\nnonsense = 1\n"));
  expect(virSlam("run " + quoted(file("u.ini")) + " --rawlog " + quoted(file("a.rawlog"))), 2,
         "u.ini:2: [Estimator] nonsense: unknown key");
  test::writeText(file("u.yaml"), test::utf16("cam0:\n  intrinsics: [1, 2]\n"));
  expect(virSlam("check " + source() + " --calibration " + quoted(file("u.yaml"))), 2,
         "intrinsics");
}

}  // namespace
}  // namespace vir
