#include "vir/estimator/rest_detector.h"

#include <algorithm>
#include <cmath>

#include "vir/core/order_statistics.h"

namespace vir::estimator {
namespace {

/// Readings that do not shake are held against the means this loosely: gains of the accelerometer
/// that are still unknown are in them.
constexpr double kQuietMargin = 2;

}  // namespace

void describe(OptionVisitor& v, RestOptions& o) {
  v.section("Rest", "When the platform counts as standing still");
  v.value("min_time_s", o.min_time_s, {0.05, 60.0}, "how long nothing must have moved");
  v.value("max_flow_px", o.max_flow_px, {0.01, 100.0},
          "median motion of the tracks against the reference image");
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

bool RestDetector::update(const vision::TrackedFrame& frame, const imu::ImuBuffer& imu) {
  if (!frame.usable) return standing_ = false;
  std::vector<double> flow;
  std::size_t j = 0;
  for (const vision::FeatureObservation& o : frame.features) {
    while (j < reference_.size() && reference_[j].id < o.id) ++j;
    if (j < reference_.size() && reference_[j].id == o.id) {
      flow.push_back((reference_[j].px - o.px).norm());
    }
  }
  if (static_cast<int>(flow.size()) < options_.min_tracks) {
    setReference(frame);
    return false;
  }
  if (medianInPlace(&flow) > options_.max_flow_px) {
    setReference(frame);
    return false;
  }
  if (toSeconds(frame.t - reference_t_) < options_.min_time_s) return standing_ = false;
  const TimeNs from = std::max(reference_t_, frame.t - fromSeconds(2 * options_.min_time_s));
  Vec3 gyro, acc;
  if (!imu.statistics(from, frame.t, &gyro, &acc, &gyro_std_, &acc_std_)) {
    return standing_ = false;
  }
  const bool quiet =
      gyro_std_ < options_.max_gyro_std_radps && acc_std_ < options_.max_acc_std_mps2;
  shaken_ = !quiet;
  const bool enough = quiet || static_cast<int>(flow.size()) >= options_.min_tracks_shaken;
  // Before there is a state nothing is known of the accelerometer's bias: quiet must do.
  const bool mean = (quiet && !expected_.state_known) ||
                    meanAtRest(gyro, acc, toSeconds(frame.t - from), quiet ? kQuietMargin : 1);
  return standing_ = enough && mean && !expected_.moving;
}

}  // namespace vir::estimator
