#include <Eigen/Core>
#include <cmath>
//
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include "observations.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_camera.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/range_differences.h"

namespace vir::simulator {

using namespace mrpt::obs;

CObservation::Ptr rangeObservation(const char* label, const simulation::SimulatedRange& range,
                                   const Vec3& antenna, double sigma_m) {
  Range measured{range.t, static_cast<std::uint32_t>(range.anchor), range.range_m, sigma_m,
                 antenna};
  if (range.reference) {
    measured.sigma_m = std::sqrt(2.0) * sigma_m;
    measured.reference = static_cast<std::uint32_t>(*range.reference);
    return rawlog::differenceObservation(measured);
  }
  return rawlog::toObservation(measured, label, rawlog::kUnknownRadio);
}

CObservation::Ptr toldObservation(int peer, const simulation::ToldPosition& told) {
  PeerBroadcast broadcast{peer, std::nullopt, {0, told.p_O, told.covariance}};
  if (told.anchor >= 0) broadcast.anchor = static_cast<std::uint64_t>(told.anchor);
  return rawlog::toObservation(broadcast, rawlog::kPeerLabel);
}

CObservationImage::Ptr emptyImage(int camera, const CameraCalibration& calibration,
                                  const Pose& T_B_C) {
  const std::string number = std::to_string(camera);
  auto obs = std::make_shared<CObservationImage>();
  obs->sensorLabel = rawlog::furtherLabel(rawlog::kCameraLabel, number);
  obs->cameraParams = rawlog::toMrptCamera(calibration, "cam" + number);
  obs->cameraPose = rawlog::toMrptPose(T_B_C);
  return obs;
}

CObservation::Ptr tracksObservation(const vision::TrackedFrame& frame,
                                    const CameraCalibration& calibration, const Pose& T_B_C) {
  auto obs = std::make_shared<CObservationStereoImagesFeatures>();
  obs->sensorLabel = rawlog::kTracksLabel;
  obs->cameraLeft = obs->cameraRight = rawlog::toMrptCamera(calibration, "cam0");
  obs->cameraPoseOnRobot = mrpt::poses::CPose3DQuat(rawlog::toMrptPose(T_B_C));
  for (const vision::FeatureObservation& f : frame.features) {
    TStereoImageFeatures feature;
    feature.pixels.first.x = static_cast<float>(f.px.x());
    feature.pixels.first.y = static_cast<float>(f.px.y());
    feature.pixels.second = feature.pixels.first;
    feature.ID = static_cast<unsigned int>(f.id);
    obs->theFeatures.push_back(feature);
  }
  return obs;
}

}  // namespace vir::simulator
