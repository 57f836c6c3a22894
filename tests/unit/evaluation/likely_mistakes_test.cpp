#include "vir/evaluation/likely_mistakes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vir::evaluation {
namespace {

/// 20 s on a wavy circle, turning about all axes; a pose every 50 ms.
Trajectory flight() {
  Trajectory out;
  for (int i = 0; i < 400; ++i) {
    const double t = 0.05 * i;
    const Vec3 p(2 * std::sin(0.7 * t), 2 - 2 * std::cos(0.7 * t), 0.5 * std::sin(1.3 * t));
    const Quat q =
        expQuat(Vec3(0, 0, 0.7 * t)) * expQuat(Vec3(0.4 * std::sin(t), 0.3 * std::cos(1.1 * t), 0));
    out.push_back({fromSeconds(100 + t), Pose(q, p)});
  }
  return out;
}

/// A centimetre beside it, as an estimate is.
Trajectory estimate() {
  Trajectory out = flight();
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].T_W_B.p.x() += 0.01 * std::sin(0.1 * static_cast<double>(i));
  }
  return out;
}

template <typename Change>
std::vector<std::string> mistakesOf(Change change) {
  Trajectory reference = flight();
  for (StampedPose& p : reference) change(&p);
  const EvaluationOptions options;
  return likelyMistakes(reference, estimate(), options, evaluate(reference, estimate(), options));
}

bool one(const std::vector<std::string>& found, const std::string& part) {
  return found.size() == 1 && found[0].find(part) != std::string::npos;
}

TEST(LikelyMistakes, NoneInAGoodComparison) {
  EXPECT_TRUE(mistakesOf([](StampedPose*) {}).empty());
}

TEST(LikelyMistakes, NoneWhereTheEstimateIsJustBad) {
  EXPECT_TRUE(mistakesOf([](StampedPose* p) {
                p->T_W_B.p.y() += 0.3 * std::sin(2.9 * toSeconds(p->t));
              }).empty());
}

TEST(LikelyMistakes, AttitudesInAnotherOrder) {
  const auto w_first = [](StampedPose* p) {
    const Quat q = p->T_W_B.q;
    p->T_W_B.q = Quat(q.z(), q.w(), q.x(), q.y());  // w x y z, read as x y z w
  };
  EXPECT_TRUE(one(mistakesOf(w_first), "reference agree to")) << mistakesOf(w_first).size();
  EXPECT_TRUE(one(mistakesOf(w_first), "as w x y z"));
  const auto turned = [](StampedPose* p) { p->T_W_B.q = p->T_W_B.q.conjugate(); };
  EXPECT_TRUE(one(mistakesOf(turned), "the other way round"));
}

TEST(LikelyMistakes, MillimetresFeetAndInverses) {
  EXPECT_TRUE(one(mistakesOf([](StampedPose* p) { p->T_W_B.p *= 1000; }), "in mm"));
  EXPECT_TRUE(one(mistakesOf([](StampedPose* p) { p->T_W_B.p /= 0.3048; }), "in feet"));
  const auto inverse = mistakesOf([](StampedPose* p) { p->T_W_B = p->T_W_B.inverse(); });
  ASSERT_FALSE(inverse.empty());
  EXPECT_NE(inverse.back().find("the inverse"), std::string::npos) << inverse.back();
}

TEST(LikelyMistakes, AClockThatIsOff) {
  const auto found = mistakesOf([](StampedPose* p) { p->t += fromSeconds(0.12); });
  EXPECT_TRUE(one(found, "120 ms earlier")) << (found.empty() ? "none" : found[0]);
}

}  // namespace
}  // namespace vir::evaluation
