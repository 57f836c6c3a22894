#include "odometry_estimator.h"

#include <mrpt/obs/CObservationRobotPose.h>

#include "ranges_of.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir {

void OdometryEstimator::describe(OptionVisitor& v) {
  v.section("Estimator", "The estimator and which sensors of the recording it reads");
  v.value("odometry_label", odometry_label_, "sensor label of the odometry's poses");
  v.value("range_label", range_label_, "sensor label of the ranges to anchors");
  v.value("use_ranges", config_.ranges.use, "use the ranges, if the recording has any");
  window::describeMode(v, config_.long_window);
  estimator::describe(v, config_);
}

void OdometryEstimator::start(const LogSink& log) {
  loadBiasModel(&config_.ranges);
  estimator_ = std::make_unique<estimator::OdometryRangeEstimator>(config_, log);
}

bool OdometryEstimator::reads(const mrpt::obs::CObservation& observation) const {
  return observation.sensorLabel == odometry_label_ || observation.sensorLabel == range_label_ ||
         anchorEventOf(observation).has_value();
}

void OdometryEstimator::add(const mrpt::obs::CObservation& observation) {
  if (observation.sensorLabel == odometry_label_) {
    const auto* pose = dynamic_cast<const mrpt::obs::CObservationRobotPose*>(&observation);
    if (pose)
      estimator_->addOdometry(rawlog::fromMrptTime(pose->timestamp),
                              rawlog::fromMrptPose(pose->pose.mean));
  } else if (observation.sensorLabel == range_label_) {
    for (const estimator::RangeMeasurement& r : rangesOf(observation)) estimator_->addRange(r);
  } else if (const auto event = anchorEventOf(observation)) {
    estimator_->anchorDropped(event->id, event->p_B, event->sigma_m);
  }
}

std::vector<roles::StateEstimate> OdometryEstimator::take() {
  std::vector<roles::StateEstimate> out;
  for (const estimator::OdometryEstimate& e : estimator_->take()) {
    roles::StateEstimate s;
    s.t = s.t_imu = e.t;
    s.valid = e.valid;
    s.T_W_B = e.T_W_B;
    s.covariance = e.covariance;
    s.segment = e.segment;
    s.keyframe = e.keyframe;
    s.health = e.health;
    s.ms.optimise = e.ms_total;
    s.ms.total = e.ms_total;
    segments_ = e.segment;
    out.push_back(s);
  }
  return out;
}

std::vector<roles::KeyframeEstimate> OdometryEstimator::keyframes() const {
  std::vector<roles::KeyframeEstimate> out;
  for (const auto& [t, T_W_B] : estimator_->keyframes()) out.push_back({t, T_W_B});
  return out;
}

std::vector<roles::AnchorEstimate> OdometryEstimator::anchors() const {
  return toEstimates(estimator_->anchors());
}
std::vector<roles::RangeRecord> OdometryEstimator::takeRanges() {
  return toRecords(estimator_->takeRanges());
}

roles::EstimatorReport OdometryEstimator::report() const {
  roles::EstimatorReport r;
  r.counters = estimator_->counters();
  r.warnings = estimator_->warnings();
  r.resets = segments_;
  return r;
}

}  // namespace vir
