#include "vir/check/force_sign.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "vir/geometry/so3.h"

namespace vir::check {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

constexpr double kStretchS = 1.5;
constexpr std::size_t kFewestTurns = 8;
constexpr double kNoise = 0.0015;        // of a direction, about half a pixel [rad]
constexpr double kLeastParallax = 1e-3;  // [rad] below which a depth says nothing
constexpr int kFewestVotes = 200;
constexpr double kClear = 2;  // times as many on one side as on the other

/// Attitude and twice integrated force in the axes of the stretch's beginning, gravity left out.
struct Reckoning {
  Mat3 R = Mat3::Identity();
  Vec3 v = Vec3::Zero(), p = Vec3::Zero();
};

/// Carries a reckoning on along the readings, each held until the next.
class Reckoner {
 public:
  Reckoner(const std::vector<ImuSample>& samples, TimeNs from) : samples_(samples), t_(from) {
    const auto after = std::upper_bound(samples.begin(), samples.end(), from,
                                        [](TimeNs t, const ImuSample& s) { return t < s.t; });
    next_ = static_cast<std::size_t>(after - samples.begin());
  }
  /// False where no reading reaches to `t`.
  bool to(TimeNs t) {
    while (t_ < t) {
      if (next_ == 0 || next_ >= samples_.size()) return false;
      const ImuSample& s = samples_[next_ - 1];
      const TimeNs end = std::min(t, samples_[next_].t);
      const double dt = toSeconds(end - t_);
      const Vec3 a = state_.R * expSO3(s.gyro * (dt / 2)) * s.acc;
      state_.p += state_.v * dt + a * (dt * dt / 2);
      state_.v += a * dt;
      state_.R = state_.R * expSO3(s.gyro * dt);
      t_ = end;
      if (samples_[next_].t <= t) ++next_;
    }
    return true;
  }
  const Reckoning& state() const { return state_; }

 private:
  const std::vector<ImuSample>& samples_;
  std::size_t next_ = 0;
  TimeNs t_;
  Reckoning state_;
};

/// A pair of images: the step between them is J x + force, x = (velocity, gravity).
struct Step {
  Eigen::Matrix<double, 3, 6> J;
  Vec3 force;
  std::vector<Vec3> before, after;  ///< directions in the stretch's axes
  Mat3 information;                 ///< of the step, across the epipolar planes
  std::vector<double> weights;
};

/// What the directions say of the step: weights of matches that agree, and its information.
void weigh(Step* s) {
  const std::size_t n = s->before.size();
  s->weights.assign(n, 1);
  for (int round = 0; round < 4; ++round) {
    s->information.setZero();
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 normal = s->before[i].cross(s->after[i]);
      s->information += s->weights[i] * normal * normal.transpose();
    }
    if (round == 3) break;
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(s->information);
    const Vec3 along = eigen.eigenvectors().col(0);
    for (std::size_t i = 0; i < n; ++i) {
      const double e = s->before[i].cross(s->after[i]).dot(along) / kNoise;
      s->weights[i] = 1 / ((1 + e * e) * (1 + e * e));
    }
  }
  s->information /= kNoise * kNoise;
}

/// +1, -1 or 0: on which side of the camera the points of a stretch are.
int sideOf(const std::vector<Step>& steps) {
  Mat6 H = Mat6::Zero();
  Vec6 b = Vec6::Zero();
  for (const Step& s : steps) {
    H += s.J.transpose() * s.information * s.J;
    b -= s.J.transpose() * s.information * s.force;
  }
  const Vec6 x = H.ldlt().solve(b);
  if (!x.allFinite()) return 0;
  int front = 0, back = 0;
  for (const Step& s : steps) {
    const Vec3 d = s.J * x + s.force;
    for (std::size_t i = 0; i < s.before.size(); ++i) {
      const double cosine = s.before[i].dot(s.after[i]);
      const double parallax2 = 1 - cosine * cosine;
      if (s.weights[i] < 0.5 || parallax2 < kLeastParallax * kLeastParallax) continue;
      // d = l0 before - l1 after
      const double l0 = (s.before[i].dot(d) - cosine * s.after[i].dot(d)) / parallax2;
      const double l1 = (cosine * s.before[i].dot(d) - s.after[i].dot(d)) / parallax2;
      front += l0 > 0 && l1 > 0 ? 1 : 0;
      back += l0 < 0 && l1 < 0 ? 1 : 0;
    }
  }
  if (front + back < kFewestVotes) return 0;
  if (front > kClear * back) return 1;
  return back > kClear * front ? -1 : 0;
}

Vec3 direction(const Mat3& R, float x, float y) {
  return R * Vec3(static_cast<double>(x), static_cast<double>(y), 1).normalized();
}

}  // namespace

int ForceSign::sign() const {
  if (with >= 3 && with >= 4 * against) return 1;
  return against >= 3 && against >= 4 * with ? -1 : 0;
}

ForceSign forceSign(const std::vector<ImageTurn>& turns, const std::vector<ImuSample>& samples,
                    const Mat3& R_B_C, double time_offset_s) {
  ForceSign out;
  const TimeNs offset = fromSeconds(time_offset_s);
  std::size_t i = 0;
  while (i < turns.size()) {
    const TimeNs start = turns[i].t0 + offset;
    Reckoner reckoner(samples, start);
    std::vector<Step> steps;
    for (; i < turns.size() && toSeconds(turns[i].t1 + offset - start) <= kStretchS; ++i) {
      const ImageTurn& turn = turns[i];
      Step s;
      const double t0 = toSeconds(turn.t0 + offset - start);
      const double t1 = toSeconds(turn.t1 + offset - start);
      if (!reckoner.to(turn.t0 + offset)) continue;
      const Reckoning before = reckoner.state();
      if (!reckoner.to(turn.t1 + offset)) continue;
      const Reckoning& after = reckoner.state();
      s.J << (t1 - t0) * Mat3::Identity(), 0.5 * (t1 * t1 - t0 * t0) * Mat3::Identity();
      s.force = after.p - before.p;
      for (const Eigen::Vector4f& m : turn.matches) {
        s.before.push_back(direction(before.R * R_B_C, m(0), m(1)));
        s.after.push_back(direction(after.R * R_B_C, m(2), m(3)));
      }
      weigh(&s);
      steps.push_back(std::move(s));
    }
    // One that is longer than a stretch has no place in any.
    if (i < turns.size() && turns[i].t0 + offset == start) ++i;
    if (steps.size() < kFewestTurns) continue;
    const int side = sideOf(steps);
    out.with += side > 0 ? 1 : 0;
    out.against += side < 0 ? 1 : 0;
  }
  return out;
}

}  // namespace vir::check
