#include <Eigen/Core>
//
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include "observations.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_camera.h"
#include "vir/rawlog/mrpt_pose.h"

namespace vir::simulator {

using namespace mrpt::obs;

CObservation::Ptr imuObservation(const ImuSample& s) {
  auto obs = std::make_shared<CObservationIMU>();
  obs->sensorLabel = rawlog::kImuLabel;
  obs->set(IMU_WX, s.gyro.x());
  obs->set(IMU_WY, s.gyro.y());
  obs->set(IMU_WZ, s.gyro.z());
  obs->set(IMU_X_ACC, s.acc.x());
  obs->set(IMU_Y_ACC, s.acc.y());
  obs->set(IMU_Z_ACC, s.acc.z());
  return obs;
}

CObservation::Ptr poseObservation(const char* label, const Pose& pose) {
  auto obs = std::make_shared<CObservationRobotPose>();
  obs->sensorLabel = label;
  obs->pose.mean = rawlog::toMrptPose(pose);
  obs->pose.cov.setZero();
  return obs;
}

CObservation::Ptr rangeObservation(const char* label, const simulation::SimulatedRange& range,
                                   const Vec3& antenna, double sigma_m) {
  auto obs = std::make_shared<CObservationBeaconRanges>();
  obs->sensorLabel = label;
  obs->minSensorDistance = 0;
  obs->maxSensorDistance = 1000;
  obs->stdError = static_cast<float>(sigma_m);
  CObservationBeaconRanges::TMeasurement m;
  m.sensorLocationOnRobot = mrpt::poses::CPoint3D(antenna.x(), antenna.y(), antenna.z());
  m.sensedDistance = static_cast<float>(range.range_m);
  m.beaconID = range.anchor;
  obs->sensedData.push_back(m);
  return obs;
}

CObservation::Ptr toldObservation(int peer, const simulation::ToldPosition& told) {
  PeerBroadcast broadcast{peer, std::nullopt, {0, told.p_O, told.covariance}};
  if (told.anchor >= 0) broadcast.anchor = static_cast<std::uint64_t>(told.anchor);
  return rawlog::toObservation(broadcast, rawlog::kPeerLabel);
}

CObservationImage::Ptr emptyImage(const CameraCalibration& calibration, const Pose& T_B_C) {
  auto obs = std::make_shared<CObservationImage>();
  obs->sensorLabel = rawlog::kCameraLabel;
  obs->cameraParams = rawlog::toMrptCamera(calibration, "cam0");
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
