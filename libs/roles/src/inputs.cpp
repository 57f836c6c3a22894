#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include <algorithm>

#include "vir/rawlog/labels.h"
#include "vir/roles/estimator.h"

namespace vir::roles {
namespace {

template <typename Class>
bool is(const mrpt::obs::CObservation& observation) {
  return dynamic_cast<const Class*>(&observation) != nullptr;
}

}  // namespace

const char* name(InputKind kind) {
  switch (kind) {
    case InputKind::image:
      return "images";
    case InputKind::tracks:
      return "feature tracks";
    case InputKind::imu:
      return "an IMU";
    case InputKind::ranges:
      return "ranges";
    case InputKind::pose:
      break;
  }
  return "poses";
}

bool matches(const EstimatorInput& input, const mrpt::obs::CObservation& observation) {
  if (observation.sensorLabel != input.label) return false;
  switch (input.kind) {
    case InputKind::image:
      return is<mrpt::obs::CObservationImage>(observation);
    case InputKind::tracks:
      return is<mrpt::obs::CObservationStereoImagesFeatures>(observation);
    case InputKind::imu:
      return is<mrpt::obs::CObservationIMU>(observation);
    case InputKind::ranges:
      return is<mrpt::obs::CObservationBeaconRanges>(observation);
    case InputKind::pose:
      break;
  }
  return is<mrpt::obs::CObservationRobotPose>(observation);
}

bool takes(const std::vector<EstimatorInput>& inputs, const mrpt::obs::CObservation& observation) {
  return rawlog::isDeployedAnchorLabel(observation.sensorLabel) ||
         rawlog::differenceReferenceOf(observation.sensorLabel).has_value() ||
         std::any_of(inputs.begin(), inputs.end(),
                     [&](const EstimatorInput& input) { return matches(input, observation); });
}

bool isOfFurtherCamera(const std::vector<EstimatorInput>& inputs,
                       const mrpt::obs::CObservation& observation) {
  bool first = true;
  for (const EstimatorInput& input : inputs) {
    if (input.kind != InputKind::image) continue;
    if (matches(input, observation)) return !first;
    first = false;
  }
  return false;
}

}  // namespace vir::roles
