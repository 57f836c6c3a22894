/// A real drone and one anchor: height of the path nearly constant, range errors correlated.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <fstream>
#include <map>
#include <sstream>

#include "vir/ranging/anchor_initialization.h"
#include "vir_test_data.h"

namespace {

using vir::Vec3;

struct Recording {
  std::vector<vir::ranging::AntennaRange> ranges;
  Vec3 anchor = Vec3::Zero();
};

Recording read(const std::filesystem::path& file) {
  Recording out;
  std::map<std::string, Vec3> poses;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::istringstream fields(line);
    std::string kind, t, name, landmark;
    fields >> kind;
    if (kind == "VERTEX_XYZ") {  // the only line without a time
      fields >> name >> out.anchor.x() >> out.anchor.y() >> out.anchor.z();
      continue;
    }
    fields >> t >> name;
    Vec3 p;
    if (kind == "VERTEX_SE3:QUAT" && fields >> p.x() >> p.y() >> p.z()) poses[name] = p;
    double range = 0;
    if (kind == "EDGE_RANGE" && fields >> landmark >> range) {
      out.ranges.push_back({poses.at(name), range, 0.04});
    }
  }
  return out;
}

TEST(AnchorRecording, SingleDroneWithItsTruePath) {
  VIR_REQUIRE_DATA(file, "range_graphs/single_drone.pyfg");
  const Recording recording = read(file);
  ASSERT_EQ(recording.ranges.size(), 1754u);
  vir::ranging::AnchorInitOptions options;
  options.drift_ratio = 0;
  const auto r = vir::ranging::initializeAnchor(recording.ranges, options);
  ASSERT_TRUE(r.geometry == vir::ranging::AnchorGeometry::good ||
              r.geometry == vir::ranging::AnchorGeometry::mirror)
      << name(r.geometry) << r.advice;
  for (const auto& s : r.solutions) {
    const Vec3 e = s.p_W - recording.anchor;
    EXPECT_LT(e.head<2>().norm(), 0.3);
    // The path is nearly level and the ranges resemble one another: the height is the weakest, and
    // its sigma must say so.
    const double sigma_z = std::sqrt(s.covariance(2, 2));
    EXPECT_GT(sigma_z, 2 * std::sqrt(s.covariance(0, 0)));
    EXPECT_GT(sigma_z, 0.05);
  }
  EXPECT_LT(std::abs(r.solutions[0].p_W.z() - recording.anchor.z()),
            4 * std::sqrt(r.solutions[0].covariance(2, 2)));
  EXPECT_GT(r.variance_factor, 10);  // lag-one correlation 0.86
}

}  // namespace
