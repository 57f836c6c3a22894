#include "vir/types/odometry_noise.h"

#include <gtest/gtest.h>

#include <string>

#include "vir/core/ini_writer.h"

namespace vir {
namespace {

TEST(OdometryNoise, VariancesGrowWithDistanceTurnAndTime) {
  OdometryNoise o;
  EXPECT_EQ(o.positionVariance(4, 2, 9), 0);
  o.sigma_per_sqrt_m = 0.1;
  EXPECT_DOUBLE_EQ(o.positionVariance(4, 2, 9), 0.04);
  o.sigma_per_rad_m = 0.2;
  EXPECT_DOUBLE_EQ(o.positionVariance(0, 2, 0), 0.16);
  o.sigma_per_sqrt_s = 0.3;
  EXPECT_DOUBLE_EQ(o.positionVariance(4, 2, 9), 0.04 + 0.16 + 0.81);
  o.yaw_per_sqrt_m = 0.1;
  o.yaw_per_sqrt_rad = 0.2;
  o.yaw_per_sqrt_s = 0.3;
  EXPECT_DOUBLE_EQ(o.yawVariance(4, 2, 9), 0.04 + 0.08 + 0.81);
  EXPECT_GT(o.usableVerticalShare(), 0) << "motion in a plane still has an inverse";
}

TEST(OdometryNoise, EverySettingIsDescribed) {
  IniWriter writer(IniWriter::Style::values);
  OdometryNoise o;
  writer.section("Odometry", "");
  describe(writer, o);
  for (const char* key :
       {"sigma_per_sqrt_m", "sigma_per_rad_m", "sigma_per_sqrt_s", "yaw_per_sqrt_m",
        "yaw_per_sqrt_rad", "yaw_per_sqrt_s", "vertical_share"}) {
    EXPECT_NE(writer.text().find(std::string(key) + " ="), std::string::npos) << writer.text();
  }
}

}  // namespace
}  // namespace vir
