/// Tables as other programs and other countries write them, from the file to the row.
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

#include "recording.h"
#include "table_folder.h"
#include "vir_test_temp_folder.h"

namespace vir::euroc {
namespace {

constexpr TimeNs kNoon = 1'714'564'800'000'000'000;  // 2024-05-01 12:00 UTC
constexpr TimeNs kStep = 5'000'000;
constexpr int kRows = 60;
constexpr double kG = 9.80665, kDeg = 0.017453292519943295;

class Notations : public ::testing::Test {
 protected:
  void table(const std::string& file, const std::string& header,
             const std::function<std::string(int)>& row) {
    std::string text = header + "\n";
    for (int i = 0; i < kRows; ++i) text += row(i) + "\n";
    std::filesystem::create_directories((temp_.path() / file).parent_path());
    test::writeText(temp_.path() / file, text);
  }
  /// Turning at 0.5 rad/s about z, at rest otherwise.
  void plainImu() {
    table("imu.csv", "t,wx,wy,wz,ax,ay,az",
          [](int i) { return std::to_string(kNoon + i * kStep) + ",0,0,0.5,0,0,9.80665"; });
  }
  void read() {
    EurocOptions o;
    o.section = "csv";
    o.source = temp_.path().string();
    Recording recording(findTables(o), o, &log_);
    Event e;
    while (recording.next(&e)) {
      if (auto* imu = std::get_if<ImuSample>(&e.what)) imu_.push_back(*imu);
      if (auto* pose = std::get_if<PoseRow>(&e.what)) truth_.push_back(*pose);
    }
  }
  bool says(const std::string& part) const {
    for (const std::string& m : log_.messages()) {
      if (m.find(part) != std::string::npos) return true;
    }
    return false;
  }
  /// The whole of the plain recording, to the last digit that the text holds.
  void expectPlainImu(TimeNs first = kNoon) {
    ASSERT_EQ(imu_.size(), static_cast<std::size_t>(kRows));
    for (int i = 0; i < kRows; ++i) {
      const ImuSample& s = imu_[static_cast<std::size_t>(i)];
      ASSERT_EQ(s.t, first + i * kStep) << i;
      ASSERT_NEAR(s.gyro.z(), 0.5, 1e-9);
      ASSERT_NEAR(s.acc.z(), kG, 1e-9);
    }
  }
  static std::string padded(int n, int width) {
    const std::string text = std::to_string(n);
    return std::string(static_cast<std::size_t>(width) - text.size(), '0') + text;
  }

  test::TempFolder temp_;
  ProblemLog log_;
  std::vector<ImuSample> imu_;
  std::vector<PoseRow> truth_;
};

TEST_F(Notations, DatesMilligravityMillidegrees) {
  table("log.csv",
        "Time,acc_x (mg),acc_y (mg),acc_z (mg),gyro_x [mdps],gyro_y [mdps],gyro_z [mdps],"
        "mag_x (mT),mag_y (mT),mag_z (mT)",
        [](int i) {
          return "2024-05-01 14:00:00." + padded(5 * i, 3) +
                 "+02:00,0,0,1000,0,0,28647.88975654116,40,41,42";
        });
  read();
  expectPlainImu();
  EXPECT_TRUE(says("the stamps are dates"));
}

TEST_F(Notations, GermanSpreadsheet) {
  table("messung.csv",
        "Datum;Time;a_x / g;a_y / g;a_z / g;wx / (\xC2\xB0/s);wy / (\xC2\xB0/s);wz / (\xC2\xB0/s)",
        [](int i) {
          return "01.05.2024;12:00:00," + padded(5 * i, 3) + ";0,0;0;1,0;0;0,0;28,64788975654116";
        });
  read();
  expectPlainImu();
}

TEST_F(Notations, TimesOfDayAcrossMidnight) {
  table("imu.csv", "time,wx,wy,wz,ax,ay,az", [](int i) {
    const int ms = 900 + 5 * i;
    return std::string(ms < 1000 ? "23:59:59." : "00:00:00.") + padded(ms % 1000, 3) +
           ",0,0,0.5,0,0,9.80665";
  });
  read();
  expectPlainImu(86'399'900'000'000);
  EXPECT_TRUE(says("times of day"));
}

TEST_F(Notations, AnglesInDegreesInAnyOrder) {
  plainImu();
  table("truth.csv", "timestamp,yaw_deg,x,y,z,roll_deg,pitch_deg",
        [](int i) { return std::to_string(kNoon + i * kStep) + ",90,1,2,3,30,0"; });
  read();
  ASSERT_EQ(truth_.size(), static_cast<std::size_t>(kRows));
  const Quat expected = Quat(Eigen::AngleAxisd(90 * kDeg, Vec3::UnitZ())) *
                        Quat(Eigen::AngleAxisd(30 * kDeg, Vec3::UnitX()));
  EXPECT_TRUE(truth_[5].has_attitude);
  EXPECT_LT(truth_[5].T_W_B.q.angularDistance(expected), 1e-9);
  EXPECT_TRUE(says("Rz(yaw) Ry(pitch) Rx(roll)"));
}

TEST_F(Notations, AnAttitudeThatCannotBeToldIsSaid) {
  plainImu();
  table("truth.csv", "timestamp,x,y,z,heading",
        [](int i) { return std::to_string(kNoon + i * kStep) + ",1,2,3,90"; });
  read();
  ASSERT_EQ(truth_.size(), static_cast<std::size_t>(kRows));
  EXPECT_FALSE(truth_[5].has_attitude);
  EXPECT_TRUE(says("heading"));
  EXPECT_TRUE(says("roll_deg, pitch_deg, yaw_deg"));
}

TEST_F(Notations, APlaceOfAnAnchorIsNoRange) {
  plainImu();
  table("uwb/data.csv", "#timestamp [ns],anchor_id,range [m]",
        [](int i) { return std::to_string(kNoon + i * kStep) + ",0,2.5"; });
  test::writeText(temp_.path() / "uwb/anchors_truth.csv",
                  "#id,x,y,z in the ground truth's frame [m]\n0,2.6,0.5,2.6\n");
  read();
  EXPECT_TRUE(says("uwb/anchors_truth.csv: taken for positions of anchors"));
  EXPECT_TRUE(says("uwb/data.csv: taken for ranges (UWB0)"));
}

TEST_F(Notations, QuaternionsOfZeros) {
  plainImu();
  table("truth.csv", "timestamp,x,y,z,qx,qy,qz,qw",
        [](int i) { return std::to_string(kNoon + i * kStep) + ",1,2,3,0,0,0,0"; });
  read();
  ASSERT_EQ(truth_.size(), static_cast<std::size_t>(kRows));
  EXPECT_FALSE(truth_[5].has_attitude);
  EXPECT_TRUE(says("all 0 0 0 0"));
}

TEST_F(Notations, SingleQuaternionsOfZerosAreLeftOutAndCounted) {
  plainImu();
  table("truth.csv", "timestamp,x,y,z,qx,qy,qz,qw", [](int i) {
    return std::to_string(kNoon + i * kStep) + ",1,2,3,0,0,0," + (i % 10 == 0 ? "0" : "1");
  });
  read();
  EXPECT_EQ(truth_.size(), static_cast<std::size_t>(kRows - kRows / 10));
  EXPECT_EQ(log_.get("ground_truth_no_attitude"), kRows / 10);
}

}  // namespace
}  // namespace vir::euroc
