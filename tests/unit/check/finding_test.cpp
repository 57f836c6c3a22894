#include "vir/check/finding.h"

#include <gtest/gtest.h>

namespace vir::check {
namespace {

TEST(Finding, NamesTheKeyOfTheRecordingsOwnDriver) {
  Finding f{Severity::unusable, "acc_in_g", "IMU0", "", "", "--set DRIVER.acc_unit=g, or multiply"};
  Finding other = f;
  nameDriver("bag", &f);
  EXPECT_EQ(f.remedy, "--set bag.acc_unit=g, or multiply");
  nameDriver("", &other);
  EXPECT_EQ(other.remedy,
            "--set DRIVER.acc_unit=g, or multiply; DRIVER is what imported it: euroc, csv, bag or "
            "rosbag2");
}

}  // namespace
}  // namespace vir::check
