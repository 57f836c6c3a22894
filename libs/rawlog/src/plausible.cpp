#include "vir/rawlog/plausible.h"

#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include <algorithm>
#include <cmath>

#include "vir/core/time_bounds.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir::rawlog {
namespace {

constexpr double kFarthestSensor = 1000;  // [m] from the body
constexpr double kFarthestPose = 1e8;     // [m]; geocentric coordinates are below
constexpr double kNoRotation = 1e-3;      // of an element of R^T R

bool within(const mrpt::poses::CPose3D& T, double farthest) {
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(T[static_cast<unsigned>(i)]) < farthest)) return false;
  }
  return true;
}

bool isRotation(const mrpt::poses::CPose3D& T) {
  const auto& R = T.getRotationMatrix();
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += R(k, i) * R(k, j);
      if (!(std::abs(sum - (i == j ? 1 : 0)) < kNoRotation)) return false;
    }
  }
  return true;
}

std::string ofSensor(const mrpt::poses::CPose3D& T, const std::string& what) {
  if (!isRotation(T)) return "the pose of the " + what + " on the robot is no rotation";
  if (!within(T, kFarthestSensor)) return "the " + what + " is more than 1 km off the robot";
  return {};
}

std::string ofLens(const mrpt::img::TCamera& c) {
  bool good = std::isfinite(c.fx() + c.fy() + c.cx() + c.cy());
  for (const double d : c.dist) good = good && std::isfinite(d);
  return good ? "" : "the camera's intrinsics are no numbers";
}

}  // namespace

std::string implausible(const mrpt::obs::CObservation& observation) {
  using namespace mrpt::obs;
  if (!isStamp(fromMrptTime(observation.timestamp))) {
    return "it has no stamp, or one that no clock shows (before 1970 or after 2099)";
  }
  if (const auto* image = dynamic_cast<const CObservationImage*>(&observation)) {
    const std::string placed = ofSensor(image->cameraPose, "camera");
    return placed.empty() ? ofLens(image->cameraParams) : placed;
  }
  if (const auto* tracks = dynamic_cast<const CObservationStereoImagesFeatures*>(&observation)) {
    const std::string placed = ofSensor(mrpt::poses::CPose3D(tracks->cameraPoseOnRobot), "camera");
    return placed.empty() ? ofLens(tracks->cameraLeft) : placed;
  }
  if (const auto* imu = dynamic_cast<const CObservationIMU*>(&observation)) {
    return ofSensor(imu->sensorPose, "IMU");
  }
  if (const auto* pose = dynamic_cast<const CObservationRobotPose*>(&observation)) {
    if (!isRotation(pose->pose.mean)) return "a pose is no rotation";
    return within(pose->pose.mean, kFarthestPose) ? ""
                                                  : "a position is no number, or off the Earth";
  }
  if (const auto* ranges = dynamic_cast<const CObservationBeaconRanges*>(&observation)) {
    for (const auto& m : ranges->sensedData) {
      const auto& p = m.sensorLocationOnRobot;
      const double farthest = std::max({std::abs(p.x()), std::abs(p.y()), std::abs(p.z())});
      if (!std::isfinite(p.x() + p.y() + p.z()) || farthest > kFarthestSensor) {
        return "the antenna is more than 1 km off the robot";
      }
    }
  }
  return {};
}

}  // namespace vir::rawlog
