#include "graph_line.h"

#include <gtest/gtest.h>

#include "vir_test_pyfg.h"

namespace vir::pyfg {
namespace {

Line parsed(const std::string& text) {
  Line line;
  LineFault fault;
  EXPECT_TRUE(parseLine(text, &line, &fault)) << text << ": " << fault.text;
  return line;
}

std::string refused(const std::string& text) {
  Line line;
  LineFault fault;
  EXPECT_FALSE(parseLine(text, &line, &fault)) << text;
  EXPECT_FALSE(fault.text.empty());
  return fault.kind;
}

TEST(GraphLine, Vertices) {
  const auto v =
      std::get<Vertex>(parsed("VERTEX_SE3:QUAT 1675054472.0060887 A12 1.5 -2 0.25 0 0 0.6 0.8"));
  EXPECT_EQ(v.t, 1675054472006088700);
  EXPECT_EQ(toString(v.name), "A12");
  EXPECT_TRUE(v.T_W_B.p.isApprox(Vec3(1.5, -2, 0.25), 1e-15));
  EXPECT_TRUE(v.T_W_B.q.isApprox(Quat(0.8, 0, 0, 0.6), 1e-15));
  const auto w = std::get<Vertex>(parsed("VERTEX_SE2 7 b0 1e1 2 0.5"));
  EXPECT_EQ(w.t, 7'000'000'000);
  EXPECT_TRUE(w.T_W_B.p.isApprox(Vec3(10, 2, 0)));
  EXPECT_NEAR(yawOf(w.T_W_B.R()), 0.5, 1e-15);
}

TEST(GraphLine, MotionsHaveTheirCovariance) {
  const auto e = std::get<MotionEdge>(
      parsed(std::string("EDGE_SE3:QUAT 1 A0 A1 1 2 3 0 0 0 1 ") + test::kSpatialCovariance));
  EXPECT_DOUBLE_EQ(e.covariance(1, 1), 0.02);
  EXPECT_DOUBLE_EQ(e.covariance(5, 5), 0.003);
  EXPECT_FALSE(e.planar);
  const auto p = std::get<MotionEdge>(parsed("EDGE_SE2 1 A0 A1 1 2 3.2 0.04 0.01 0 0.09 0 0.02"));
  EXPECT_TRUE(p.planar);
  EXPECT_DOUBLE_EQ(p.covariance(0, 1), 0.01);
  EXPECT_DOUBLE_EQ(p.covariance(1, 0), 0.01);
  EXPECT_DOUBLE_EQ(p.covariance(5, 5), 0.02);
  EXPECT_DOUBLE_EQ(p.covariance(2, 2), 0);
  EXPECT_NEAR(yawOf(p.T_from_to.R()), 3.2 - 2 * M_PI, 1e-14);
}

TEST(GraphLine, AMatrixThatIsNoCovarianceIsSaid) {
  const auto e = std::get<MotionEdge>(parsed("EDGE_SE2 1 A0 A1 1 2 3 -0.04 0 0 0.09 0 0.02"));
  EXPECT_FALSE(e.covariance_usable);
  EXPECT_TRUE(e.covariance.isZero());
  const auto f = std::get<MotionEdge>(parsed("EDGE_SE2 1 A0 A1 1 2 3 0.04 1 0 0.09 0 0.02"));
  EXPECT_FALSE(f.covariance_usable);
  const auto g = std::get<MotionEdge>(parsed("EDGE_SE2 1 A0 A1 1 2 3 1e300 0 0 1e300 0 1e300"));
  EXPECT_FALSE(g.covariance_usable) << "would overflow when put together";
}

TEST(GraphLine, LandmarksWithAndWithoutAStamp) {
  for (const char* text : {"VERTEX_XYZ L3 1 2 3", "VERTEX_XYZ 12.5 L3 1 2 3"}) {
    const auto l = std::get<Landmark>(parsed(text));
    EXPECT_EQ(toString(l.name), "L3");
    EXPECT_TRUE(l.p_W.isApprox(Vec3(1, 2, 3)));
  }
  for (const char* text : {"VERTEX_XY L3 1 2", "VERTEX_XY 12.5 L3 1 2"}) {
    EXPECT_TRUE(std::get<Landmark>(parsed(text)).p_W.isApprox(Vec3(1, 2, 0)));
  }
}

TEST(GraphLine, Ranges) {
  const auto r = std::get<RangeEdge>(parsed("EDGE_RANGE 1.5 A0 L0 3.25 0.09"));
  EXPECT_EQ(r.t, 1'500'000'000);
  EXPECT_DOUBLE_EQ(r.range_m, 3.25);
  EXPECT_DOUBLE_EQ(r.variance, 0.09);
}

TEST(GraphLine, WhatIsWrongIsNamed) {
  EXPECT_EQ(refused("EDGE_BEARING 1 A0 L0 3 0.1"), "line_unknown_keyword");
  EXPECT_EQ(refused("edge_range 1 A0 L0 3 0.1"), "line_unknown_keyword");
  EXPECT_EQ(refused(""), "line_unknown_keyword");
  for (const char* text :
       {"EDGE_RANGE", "EDGE_RANGE 1 A0 L0 3", "EDGE_RANGE 1 A0 L0 3 0.1 7",
        "EDGE_RANGE x A0 L0 3 0.1", "EDGE_RANGE -1 A0 L0 3 0.1", "EDGE_RANGE 1 0A L0 3 0.1",
        "EDGE_RANGE 1 A L0 3 0.1", "EDGE_RANGE 1 A-1 L0 3 0.1", "EDGE_RANGE 1 A1x L0 3 0.1",
        "EDGE_RANGE 1 A99999999999 L0 3 0.1", "EDGE_RANGE 1 A0 L0 3m 0.1", "VERTEX_SE2 1 A0 1 2",
        "VERTEX_XYZ L0 1 2", "VERTEX_SE3:QUAT 1 A0 1 2 3 0 0 1"}) {
    EXPECT_EQ(refused(text), "line_malformed") << text;
  }
  EXPECT_EQ(refused("EDGE_RANGE 1 A0 L0 nan 0.1"), "line_not_finite");
  EXPECT_EQ(refused("EDGE_RANGE 1 A0 L0 3 inf"), "line_not_finite");
  EXPECT_EQ(refused("VERTEX_SE2 1 A0 1e999 2 0"), "line_not_finite");
  EXPECT_EQ(refused("EDGE_RANGE 1 A0 L0 -3 0.1"), "line_implausible");
  EXPECT_EQ(refused("EDGE_RANGE 1 A0 L0 1e9 0.1"), "line_implausible");
  EXPECT_EQ(refused("EDGE_RANGE 1 A0 L0 3 0"), "line_implausible");
  EXPECT_EQ(refused("EDGE_RANGE 1 A0 L0 3 -0.1"), "line_implausible");
  EXPECT_EQ(refused("VERTEX_SE2 1 A0 1e8 2 0"), "line_implausible");
  EXPECT_EQ(refused("VERTEX_SE3:QUAT 1 A0 1 2 3 0 0 0 0"), "line_bad_quaternion");
  EXPECT_EQ(refused("VERTEX_SE3:QUAT 1 A0 1 2 3 0 0 0.6 0.9"), "line_bad_quaternion");
}

}  // namespace
}  // namespace vir::pyfg
