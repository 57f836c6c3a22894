/// Where an image was taken by what it sees of the landmarks, whatever the IMU says.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "vir/core/order_statistics.h"
#include "window_state.h"

namespace vir::window {
namespace {

constexpr int kSteps = 8;
/// Fewer sights give no pose that could contradict anything.
constexpr std::size_t kFewestSights = 12;
/// A sight that moves more slowly tells no time [px/s].
constexpr double kLeastSpeed = 30;
/// What is further off than this many medians hardly counts.
constexpr double kMedians = 1.5;

struct Match {
  const WindowLandmark* landmark = nullptr;
  LandmarkSight seen;
  double speed_px = 0;  ///< along its way [px/s]
};

class Resection {
 public:
  Resection(const WindowState& w, std::vector<Match> matches)
      : w_(w), matches_(std::move(matches)) {
    for (int k = 0; k < w.cameras(); ++k) T_B_C_.push_back(w.T_B_C(k));
  }

  SightFit fit(const Pose& T_W_B) {
    off_.clear();
    for (const Match& m : matches_) off_.push_back(residual(m, T_W_B, nullptr).norm());
    SightFit out;
    out.sights = static_cast<int>(off_.size());
    out.median_px = medianInPlace(&off_) * w_.options.sigma_px;
    return out;
  }

  /// Each sight that moves tells how far it is ahead along its way: the median of them.
  std::optional<double> late(const Pose& T_W_B) {
    off_.clear();
    for (const Match& m : matches_) {
      const Vec2 way = m.seen.sight.weight * m.seen.sight.by_camera.col(factors::kTimeOffset);
      if (m.speed_px < kLeastSpeed) continue;
      off_.push_back(way.dot(residual(m, T_W_B, nullptr)) / way.squaredNorm());
    }
    if (off_.size() < kFewestSights) return std::nullopt;
    return medianInPlace(&off_);
  }

  /// Gauss-Newton with Cauchy's weights about the median.
  Pose pose(Pose T_W_B) {
    for (int step = 0; step < kSteps; ++step) {
      const double scale = std::max(1.0, kMedians * fit(T_W_B).median_px / w_.options.sigma_px);
      Eigen::Matrix<double, 6, 6> H = 1e-9 * Eigen::Matrix<double, 6, 6>::Identity();
      Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
      factors::RigJacobians J;
      for (const Match& m : matches_) {
        const Vec2 r = residual(m, T_W_B, &J);
        const double weight = 1 / (1 + r.squaredNorm() / (scale * scale));
        H += weight * J.pose_j.transpose() * J.pose_j;
        b += weight * J.pose_j.transpose() * r;
      }
      const Eigen::Matrix<double, 6, 1> change = -H.ldlt().solve(b);
      if (!change.allFinite()) break;
      T_W_B.p += change.head<3>();
      T_W_B.q = (T_W_B.q * expQuat(change.tail<3>())).normalized();
    }
    return T_W_B;
  }

 private:
  Vec2 residual(const Match& m, const Pose& T_W_B, factors::RigJacobians* J) const {
    const WindowLandmark& l = *m.landmark;
    const int host = l.hostCamera(), other = m.seen.camera;
    const factors::SightGeometry between(l.host()->T_W_B(), T_W_B,
                                         T_B_C_[static_cast<std::size_t>(host)],
                                         T_B_C_[static_cast<std::size_t>(other)]);
    return factors::rigResidual(l.ray, m.seen.sight, between, Vec3(l.x[0], l.x[1], l.x[2]),
                                w_.cameraVector(host), w_.cameraVector(other), J);
  }

  const WindowState& w_;
  std::vector<Match> matches_;
  std::vector<Pose> T_B_C_;  // by camera
  std::vector<double> off_;
};

}  // namespace

Resected resect(const WindowState& w, const Pose& predicted,
                const std::vector<vision::FeatureObservation>& features, double far_px) {
  std::vector<Match> matches;
  for (const vision::FeatureObservation& o : features) {
    const auto at = w.landmarks.find(o.id);
    if (at == w.landmarks.end() || !at->second.has_depth) continue;
    matches.push_back({&at->second, w.sightOf(o), (o.dpx_dbearing * o.bearing_rate).norm()});
  }
  Resected out;
  out.T_W_B = predicted;
  const bool enough = matches.size() >= kFewestSights;
  Resection resection(w, std::move(matches));
  out.predicted = out.found = resection.fit(predicted);
  out.late_s = resection.late(predicted);
  if (!enough || out.predicted.median_px < far_px) return out;
  out.T_W_B = resection.pose(predicted);
  out.found = resection.fit(out.T_W_B);
  return out;
}

}  // namespace vir::window
