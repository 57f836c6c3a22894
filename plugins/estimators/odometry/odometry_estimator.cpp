#include "odometry_estimator.h"

#include <cmath>
#include <cstdio>

#include "bias_model_file.h"
#include "vir/rawlog/anchor_ranges.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/range_differences.h"
#include "vir/roles/range_labels.h"

namespace vir {
namespace {

/// The scale that comes out is so many times further off than it may be: it is another unit.
constexpr double kOddScale = 4;

}  // namespace
void OdometrySettings::describe(OptionVisitor& v) {
  v.section("Estimator", "The estimator and which sensors of the recording it reads");
  v.value("odometry_label", odometry_label, "sensor label of the odometry's poses");
  v.value("range_label", range_label,
          "sensor label of the ranges to anchors; several with blanks between: antennas of the "
          "robot, each with its place on it in the recording");
  v.value("use_ranges", config.ranges.use, "use the ranges, if the recording has any");
  window::describeMode(v, config.long_window);
  estimator::describe(v, config);
}

std::vector<roles::EstimatorInput> OdometrySettings::inputs() const {
  std::vector<roles::EstimatorInput> out{{roles::InputKind::pose, odometry_label, 1}};
  roles::addRangeInputs(range_label, &out);
  return out;
}

std::unique_ptr<roles::Estimator> OdometrySettings::create(
    const LogSink& log, std::function<void()> /*on_estimates*/) const {
  return std::make_unique<OdometryEstimator>(*this, log);
}

OdometryEstimator::OdometryEstimator(OdometrySettings settings, const LogSink& log)
    : settings_(std::move(settings)), estimator_(withFiles(settings_.config), log) {}

void OdometryEstimator::add(const mrpt::obs::CObservation& observation) {
  if (observation.sensorLabel == settings_.odometry_label) {
    if (const auto pose = rawlog::poseOf(observation)) {
      estimator_.addOdometry(pose->t, pose->T_W_B);
    }
  } else if (roles::isAmong(observation.sensorLabel, settings_.range_label)) {
    for (const Range& r : rawlog::rangesOf(observation)) estimator_.addRange(r);
  } else if (const auto anchor = rawlog::deployedAnchorOf(observation)) {
    estimator_.anchorDeployed(anchor->id, anchor->p_B, anchor->sigma_m);
  } else {
    for (const Range& r : rawlog::rangeDifferencesOf(observation)) estimator_.addRange(r);
    for (const AnchorRange& r : rawlog::anchorRangesOf(observation)) {
      estimator_.addAnchorRange(r);
    }
  }
}

roles::EstimatorOutput OdometryEstimator::take() {
  roles::EstimatorOutput out{
      estimator_.take(), estimator_.takeRanges(), {}, {}, estimator_.takeSettled()};
  if (!out.states.empty()) segments_ = out.states.back().segment;
  return out;
}

roles::EstimatorReport OdometryEstimator::report() const {
  roles::EstimatorReport r;
  r.counters = estimator_.counters();
  r.warnings = estimator_.warnings();
  const double scale = estimator_.odometryScale(), sigma = settings_.config.long_window.scale_sigma;
  if (sigma > 0 && std::abs(std::log(scale)) > kOddScale * sigma) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "the ranges have the odometry's steps %.3g times as long as they are: another "
                  "unit, wheel radius or baseline? ([LongWindow] scale_sigma allows %.2g)",
                  scale, sigma);
    r.doubts.push_back(text);
  }
  r.resets = segments_;
  return r;
}

}  // namespace vir
