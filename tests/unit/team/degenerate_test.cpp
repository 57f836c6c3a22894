/// Geometries that leave the transform open must be named, not solved.
#include <gtest/gtest.h>

#include <functional>

#include "meetings.h"

namespace vir::team {
namespace {

using Path = std::function<Vec3(double)>;  // in A's world, of seconds

struct Scene {
  Path a, b;
  bool anchor = true;
};

TransformAnswer solve(const Scene& scene, int n, double sigma, std::uint64_t seed) {
  test::Noise noise(seed);
  const WorldTransform truth{2 * M_PI * (noise.uniform() - 0.5),
                             Vec3(noise.normal(), noise.normal(), noise.normal())};
  std::vector<MutualRange> ranges;
  for (int i = 0; i < n; ++i) {
    const double t = 0.5 * i;
    MutualRange r;
    r.t = fromSeconds(t);
    r.sigma_m = sigma;
    r.p_A = scene.a(t);
    const Vec3 b = scene.b(t);
    r.p_B = truth.inverse() * b;
    r.range_m = std::max(0.01, (r.p_A - b).norm() + sigma * noise.normal());
    ranges.push_back(r);
  }
  std::vector<SharedAnchor> anchors;
  if (scene.anchor) {
    SharedAnchor anchor;
    anchor.p_A = Vec3(1, 2, 1.5);
    anchor.p_B = truth.inverse() * anchor.p_A;
    anchor.cov_A = anchor.cov_B = 1e-4 * Mat3::Identity();
    anchors.push_back(anchor);
  }
  return findTransform(ranges, anchors, test::plainTransformOptions());
}

Vec3 roam(double t, double phase) {
  return Vec3(3 * std::sin(0.31 * t + phase), 3 * std::sin(0.23 * t + 2 * phase + 1),
              0.8 * std::sin(0.4 * t + phase));
}

void expectDegenerate(const Scene& scene, const std::string& word, int n = 40) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const TransformAnswer answer = solve(scene, n, 0.05, seed);
    EXPECT_EQ(answer.status, TransformStatus::degenerate)
        << word << ", seed " << seed << ": " << name(answer.status);
    EXPECT_NE(answer.reason.find(word), std::string::npos) << answer.reason;
  }
}

const Path kRoamA = [](double t) { return roam(t, 0.3); };
const Path kRoamB = [](double t) { return Vec3(roam(t, 2.0) + Vec3(2, 1, 0)); };

TEST(Degenerate, ARobotOnTheAnchorsVertical) {
  expectDegenerate({[](double t) { return Vec3(1, 2, 0.1 * t); }, kRoamB},
                   "robot A on the vertical");
  expectDegenerate({kRoamA, [](double t) { return Vec3(1, 2, -0.1 * t); }},
                   "robot B on the vertical");
  expectDegenerate(
      {[](double t) { return Vec3(1, 2, 0.1 * t); }, [](double t) { return Vec3(1, 2, -0.1 * t); }},
      "both robots on the vertical");
}

TEST(Degenerate, NeitherRobotMovesWithAnAnchor) {
  expectDegenerate({[](double) { return Vec3(4, 1, 0); }, [](double) { return Vec3(-2, 0, 0); }},
                   "neither robot moves");
  expectDegenerate({[](double) { return Vec3(4, 1, 0); }, [](double) { return Vec3(-2, 0, 0); }},
                   "neither robot moves", 2);
}

TEST(Degenerate, BothOnLinesThroughTheAnchor) {
  expectDegenerate({[](double t) { return Vec3(1 + 0.2 * t, 2 + 0.1 * t, 0); },
                    [](double t) { return Vec3(1 - 0.1 * t, 2 + 0.25 * t, 0.5); }},
                   "straight line through the anchor");
}

TEST(Degenerate, WithoutAnAnchorBothMustMove) {
  const Path still = [](double) { return Vec3(4, 1, 0); };
  expectDegenerate({still, kRoamB, false}, "robot A does not move");
  expectDegenerate({kRoamA, still, false}, "robot B does not move");
  expectDegenerate({still, [](double) { return Vec3(0, 1, 0); }, false}, "neither robot moves");
}

TEST(Degenerate, StraightLinesWithoutAnAnchor) {
  expectDegenerate({[](double t) { return Vec3(0.2 * t, 0.1 * t, 0); },
                    [](double t) { return Vec3(3 - 0.1 * t, 0.25 * t, 0); }, false},
                   "straight lines");
}

TEST(Degenerate, TooFewRanges) {
  const TransformAnswer none = findTransform({}, {}, TransformOptions());
  EXPECT_EQ(none.status, TransformStatus::degenerate);
  EXPECT_FALSE(none.reason.empty());
  const TransformAnswer five = solve({kRoamA, kRoamB, false}, 5, 0.05, 1);
  EXPECT_EQ(five.status, TransformStatus::degenerate);
  EXPECT_NE(five.reason.find("5 of the 6"), std::string::npos) << five.reason;
}

TEST(Degenerate, TheSameRoamingIsSolved) {
  for (const bool anchor : {true, false}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      EXPECT_EQ(solve({kRoamA, kRoamB, anchor}, 60, 0.05, seed).status, TransformStatus::unique)
          << anchor << " " << seed;
    }
  }
}

}  // namespace
}  // namespace vir::team
