#include "force_axes.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>

namespace vir::check {
namespace {

constexpr std::size_t kParts = 16, kStep = 8;  // of a stretch, and from one to the next
constexpr TimeNs kLongestPart = 400'000'000;
constexpr double kTurned = 0.3;  // [rad] within a stretch, to count
constexpr int kFewestStretches = 4, kMostStretches = 500;
// Share that averages out, and how many times less it is with other axes. Right ones had 0.012 and
// 1.65 at most, on a hand-carried and a flown recording of 30 s and parts of 15 s of them.
constexpr double kDoubtful = 0.011, kDoubtfulRatio = 2.2;
constexpr double kWrong = 0.025, kWrongRatio = 3;

/// The 24 ways to lay right-handed axes onto others.
std::vector<Mat3> axesRotations() {
  std::vector<Mat3> out;
  std::array<int, 3> p{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Mat3 S = Mat3::Zero();
      for (int i = 0; i < 3; ++i) {
        S(i, p[static_cast<std::size_t>(i)]) = ((signs >> i) & 1) != 0 ? -1 : 1;
      }
      if (S.determinant() > 0) out.push_back(S);
    }
  } while (std::next_permutation(p.begin(), p.end()));
  return out;
}

}  // namespace

ForceAxes forceAxes(const std::vector<ForceAndTurn>& parts) {
  const std::vector<Mat3> axes = axesRotations();  // the first is the identity
  std::vector<double> lost(axes.size(), 0);
  int stretches = 0;
  for (std::size_t k = 0; k + kParts < parts.size() && stretches < kMostStretches; k += kStep) {
    Mat3 R = Mat3::Identity();
    std::vector<Mat3> turned;
    double angle = 0, size = 0;
    for (std::size_t i = k; i < k + kParts; ++i) {
      const TimeNs dt = parts[i + 1].t - parts[i].t;
      if (dt <= 0 || dt > kLongestPart) break;
      const Mat3 half = expSO3(parts[i].gyro * (toSeconds(dt) / 2));
      turned.push_back(R * half);
      R = R * half * half;
      angle = std::max(angle, logSO3(R).norm());
      size += parts[i].acc.norm() / static_cast<double>(kParts);
    }
    if (turned.size() < kParts || angle < kTurned || size <= 0) continue;
    ++stretches;
    for (std::size_t a = 0; a < axes.size(); ++a) {
      Vec3 mean = Vec3::Zero();
      for (std::size_t i = 0; i < kParts; ++i) {
        mean += turned[i] * axes[a] * parts[k + i].acc / static_cast<double>(kParts);
      }
      lost[a] += 1 - mean.norm() / size;
    }
  }
  ForceAxes out;
  if (stretches < kFewestStretches) return out;
  out.as_is = lost[0] / stretches;
  out.best = *std::min_element(lost.begin(), lost.end()) / stretches;
  out.doubtful = out.as_is > kDoubtful && out.as_is > kDoubtfulRatio * out.best;
  out.wrong = out.as_is > kWrong && out.as_is > kWrongRatio * out.best;
  return out;
}

}  // namespace vir::check
