/// Numbers as no robot sends them, in every place where a number goes in: what comes out is finite,
/// and it comes.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "evidence_cost.h"
#include "explored_covariance.h"
#include "meetings.h"
#include "vir/team/find_transform.h"

namespace vir::team {
namespace {

const double kExtremes[] = {0,
                            -0.0,
                            1e-320,
                            1e-300,
                            -1,
                            1e18,
                            -1e18,
                            1e154,
                            1e308,
                            -1e308,
                            std::numeric_limits<double>::infinity(),
                            -std::numeric_limits<double>::infinity(),
                            std::numeric_limits<double>::quiet_NaN()};

test::MadeMeeting meeting() {
  test::Meeting m;
  m.ranges = 30;
  m.position_sigma_m = 0.05;
  return test::meet(m, 7);
}

TransformOptions quick() {
  TransformOptions o;
  o.max_global_evaluations = 300;
  return o;
}

void expectFinite(const TransformAnswer& answer, double value, int place) {
  for (const TransformSolution& s : answer.solutions) {
    EXPECT_TRUE(s.T_A_B.t_m.allFinite() && std::isfinite(s.T_A_B.yaw_rad) &&
                s.covariance.allFinite() && std::isfinite(s.cost))
        << value << " in place " << place;
  }
}

/// The number in place `i` of a range; false when there is no such place.
bool put(double value, int i, MutualRange* m) {
  if (i == 0) m->range_m = value;
  if (i == 1) m->sigma_m = value;
  if (i >= 2 && i < 5) m->p_A[i - 2] = value;
  if (i >= 5 && i < 8) m->p_B[i - 5] = value;
  if (i == 8) m->cov_A(0, 0) = value;
  if (i == 9) m->cov_B(1, 2) = m->cov_B(2, 1) = value;
  return i < 10;
}

TEST(ExtremeNumbers, InOneRange) {
  const test::MadeMeeting good = meeting();
  for (const double value : kExtremes) {
    auto ranges = good.ranges;
    for (int i = 0; put(value, i, &ranges[10]); ++i) {
      expectFinite(findTransform(ranges, good.anchors, quick()), value, i);
      ranges = good.ranges;
    }
  }
}

TEST(ExtremeNumbers, InEveryRange) {
  const test::MadeMeeting good = meeting();
  MutualRange unused;
  for (const double value : kExtremes) {
    for (int i = 0; put(value, i, &unused); ++i) {
      auto ranges = good.ranges;
      for (MutualRange& m : ranges) put(value, i, &m);
      expectFinite(findTransform(ranges, {}, quick()), value, i);
    }
  }
}

TEST(ExtremeNumbers, InAnAnchor) {
  const test::MadeMeeting good = meeting();
  for (const double value : kExtremes) {
    for (int i = 0; i < 4; ++i) {
      SharedAnchor a{1, Vec3(1, 2, 3), Vec3(0, 1, 0), 0.01 * Mat3::Identity(),
                     0.01 * Mat3::Identity()};
      if (i < 2) (i == 0 ? a.p_A : a.p_B).y() = value;
      if (i >= 2) (i == 2 ? a.cov_A : a.cov_B)(0, 0) = value;
      expectFinite(findTransform(good.ranges, {a}, quick()), value, i);
    }
  }
}

/// A covariance of zero once gave a first step of zero, and a walk that never ended.
TEST(ExtremeNumbers, WalkFromWhatIsExact) {
  const test::MadeMeeting good = meeting();
  const TransformOptions options;
  const EvidenceCost cost(good.ranges, good.anchors, options);
  for (const double value : kExtremes) {
    Mat4 C = Mat4::Identity();
    C(2, 2) = value;
    exploredCovariance(cost, Vec4(1, 3, -2, 0.4), C, Vec3::Zero(), 1);  // comes back
  }
}

}  // namespace
}  // namespace vir::team
