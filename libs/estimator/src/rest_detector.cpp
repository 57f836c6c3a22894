#include "vir/estimator/rest_detector.h"

#include <algorithm>

#include "vir/core/order_statistics.h"

namespace vir::estimator {

void describe(OptionVisitor& v, RestOptions& o) {
  v.section("Rest", "When the platform counts as standing still");
  v.value("min_time_s", o.min_time_s, {0.05, 60.0}, "how long nothing must have moved");
  v.value("max_flow_px", o.max_flow_px, {0.01, 100.0},
          "median motion of the tracks against the reference image");
  v.value("max_gyro_std_radps", o.max_gyro_std_radps, {1e-6, 100.0}, "vibration of the gyro");
  v.value("max_acc_std_mps2", o.max_acc_std_mps2, {1e-6, 100.0}, "vibration of the accelerometer");
  v.value("min_tracks", o.min_tracks, {3, 10000}, "tracks needed to decide");
}

void RestDetector::setReference(const vision::TrackedFrame& frame) {
  reference_ = frame.features;
  reference_t_ = frame.t;
  standing_ = false;
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
  Vec3 g, a;
  double g_std = 0, a_std = 0;
  const TimeNs from = std::max(reference_t_, frame.t - fromSeconds(2 * options_.min_time_s));
  standing_ = imu.statistics(from, frame.t, &g, &a, &g_std, &a_std) &&
              g_std < options_.max_gyro_std_radps && a_std < options_.max_acc_std_mps2;
  return standing_;
}

}  // namespace vir::estimator
