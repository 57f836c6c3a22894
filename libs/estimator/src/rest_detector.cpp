#include "vir/estimator/rest_detector.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "vir/core/order_statistics.h"

namespace vir::estimator {
namespace {

/// Readings that do not shake are held against the means this loosely: gains of the accelerometer
/// that are still unknown are in them.
constexpr double kQuietMargin = 2;

/// Who creeps looks still for a while, and each such while taken for a rest would pull the scale of
/// what is seen towards nothing. So each time that it turns out not to have been one, the next must
/// last twice as long, up to this many times the shortest.
constexpr double kLongestProof = 16;

double medianLength(const std::vector<std::pair<Vec2, Vec2>>& flow) {
  std::vector<double> lengths;
  lengths.reserve(flow.size());
  for (const auto& [px, by] : flow) lengths.push_back(by.norm());
  return medianInPlace(&lengths);
}

/// Root mean square [px] of the affine motion (shift, zoom, turn, shear) that fits the tracks: what
/// a camera that creeps has, while the noise of single tracks averages out. Without things that
/// move through the image, and tracks that jump: those far beyond the `median` length.
double commonMotion(const std::vector<std::pair<Vec2, Vec2>>& flow, double median) {
  const double far = 3 * std::max(0.01, median);
  const auto counts = [far](const std::pair<Vec2, Vec2>& f) { return f.second.norm() <= far; };
  const auto count = std::count_if(flow.begin(), flow.end(), counts);
  if (count < 6) return 0;
  const double n = static_cast<double>(count);
  Vec2 mean = Vec2::Zero();
  for (const auto& f : flow) {
    if (counts(f)) mean += f.first / n;
  }
  Mat3 H = Mat3::Zero();
  Eigen::Matrix<double, 3, 2> b = Eigen::Matrix<double, 3, 2>::Zero();
  for (const auto& f : flow) {
    if (!counts(f)) continue;
    const Vec3 at(1, (f.first.x() - mean.x()) / 100, (f.first.y() - mean.y()) / 100);
    H += at * at.transpose() / n;
    b += at * f.second.transpose() / n;
  }
  H.diagonal().array() += 1e-6;  // tracks on a line
  const Eigen::Matrix<double, 3, 2> x = H.ldlt().solve(b);
  // x^T b is the mean square of the fitted motion.
  return std::sqrt(std::max(0.0, x.col(0).dot(b.col(0)) + x.col(1).dot(b.col(1))));
}

}  // namespace

void describe(OptionVisitor& v, RestOptions& o) {
  v.section("Rest", "When the platform counts as standing still");
  v.value("min_time_s", o.min_time_s, {0.05, 60.0}, "how long nothing must have moved");
  v.value("max_flow_px", o.max_flow_px, {0.01, 100.0},
          "median motion of the tracks against the reference image");
  v.value("max_drift_px", o.max_drift_px, {0.01, 100.0},
          "motion that the tracks have in common (shift, zoom, turn), far below the noise of each");
  v.value("max_gyro_std_radps", o.max_gyro_std_radps, {1e-6, 100.0}, "vibration of the gyro");
  v.value("max_acc_std_mps2", o.max_acc_std_mps2, {1e-6, 100.0}, "vibration of the accelerometer");
  v.value("min_tracks", o.min_tracks, {3, 10000}, "tracks needed to decide");
  v.value("min_tracks_shaken", o.min_tracks_shaken, {3, 10000},
          "tracks needed while the IMU vibrates");
  v.value("max_mean_gyro_radps", o.max_mean_gyro_radps, {1e-6, 100.0},
          "while it vibrates: mean of the gyro beside its bias");
  v.value("max_mean_acc_mps2", o.max_mean_acc_mps2, {1e-6, 100.0},
          "while it vibrates: mean of the accelerometer beside gravity");
}

void RestDetector::setReference(const vision::TrackedFrame& frame) {
  reference_ = frame.features;
  reference_t_ = frame.t;
  standing_ = false;
}

bool RestDetector::meanAtRest(const Vec3& gyro, const Vec3& acc, double span_s,
                              double margin) const {
  // What white noise of this size leaves in the mean at 100 Hz, the lowest rate of use.
  const double share = 1.0 / std::sqrt(100 * std::max(0.01, span_s));
  const double gyro_limit = margin * options_.max_mean_gyro_radps + 3 * share * gyro_std_;
  const double acc_limit = margin * options_.max_mean_acc_mps2 + 3 * share * acc_std_;
  return (gyro - expected_.gyro_bias).norm() < gyro_limit &&
         std::abs(acc.norm() - expected_.gravity_mps2) < acc_limit;
}

void RestDetector::compare(const vision::TrackedFrame& frame) {
  flow_.clear();
  std::size_t j = 0;
  for (const vision::FeatureObservation& o : frame.features) {
    while (j < reference_.size() && reference_[j].id < o.id) ++j;
    if (j < reference_.size() && reference_[j].id == o.id) {
      flow_.emplace_back(o.px, o.px - reference_[j].px);
    }
  }
}

bool RestDetector::update(const vision::TrackedFrame& frame, const imu::ImuBuffer& imu) {
  if (!frame.usable) return standing_ = false;
  compare(frame);
  const int tracks = static_cast<int>(flow_.size());
  const double median = tracks > 0 ? medianLength(flow_) : 0;
  if (tracks < options_.min_tracks || median > options_.max_flow_px) {
    setReference(frame);
    needed_s_ = options_.min_time_s;
    return false;
  }
  const double still_s = toSeconds(frame.t - reference_t_);
  if (still_s < options_.min_time_s) return standing_ = false;
  const TimeNs from = std::max(reference_t_, frame.t - fromSeconds(2 * options_.min_time_s));
  Vec3 gyro, acc;
  if (!imu.statistics(from, frame.t, &gyro, &acc, &gyro_std_, &acc_std_)) {
    return standing_ = false;
  }
  const bool quiet =
      gyro_std_ < options_.max_gyro_std_radps && acc_std_ < options_.max_acc_std_mps2;
  shaken_ = !quiet;
  const bool can_creep = quiet && expected_.held;
  if (can_creep && commonMotion(flow_, median) > options_.max_drift_px) {
    setReference(frame);
    needed_s_ = std::min(2 * needed_s_, kLongestProof * options_.min_time_s);
    return false;
  }
  if (can_creep && still_s < needed_s_) return standing_ = false;
  const bool enough = quiet || tracks >= options_.min_tracks_shaken;
  // Before there is a state nothing is known of the accelerometer's bias: quiet must do.
  const bool mean = (quiet && !expected_.state_known) ||
                    meanAtRest(gyro, acc, toSeconds(frame.t - from), quiet ? kQuietMargin : 1);
  return standing_ = enough && mean && !expected_.moving;
}

}  // namespace vir::estimator
