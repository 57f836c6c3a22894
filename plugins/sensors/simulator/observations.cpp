#include <Eigen/Core>
//
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include "observations.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_pose.h"

namespace vir::simulator {

using namespace mrpt::obs;

namespace {

mrpt::img::TCamera mrptCamera(const CameraCalibration& c) {
  mrpt::img::TCamera out;
  out.ncols = static_cast<uint32_t>(c.width);
  out.nrows = static_cast<uint32_t>(c.height);
  out.cameraName = "cam0";
  out.setIntrinsicParamsFromValues(c.fx, c.fy, c.cx, c.cy);
  const auto& d = c.dist;
  if (c.distortion == Distortion::radtan) out.setDistortionPlumbBob(d[0], d[1], d[2], d[3], d[4]);
  if (c.distortion == Distortion::equidistant) {
    out.setDistortionKannalaBrandt(d[0], d[1], d[2], d[3]);
  }
  return out;
}

}  // namespace

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
  auto obs = std::make_shared<CObservationRobotPose>();
  obs->sensorLabel = std::string(rawlog::kPeerLabel) + ":" + std::to_string(peer);
  if (told.anchor >= 0) obs->sensorLabel += ":ANCHOR:" + std::to_string(told.anchor);
  obs->pose.mean = mrpt::poses::CPose3D(told.p_O.x(), told.p_O.y(), told.p_O.z(), 0, 0, 0);
  obs->pose.cov.setZero();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) obs->pose.cov(r, c) = told.covariance(r, c);
  }
  return obs;
}

CObservationImage::Ptr emptyImage(const CameraCalibration& calibration, const Pose& T_B_C) {
  auto obs = std::make_shared<CObservationImage>();
  obs->sensorLabel = rawlog::kCameraLabel;
  obs->cameraParams = mrptCamera(calibration);
  obs->cameraPose = rawlog::toMrptPose(T_B_C);
  return obs;
}

CObservation::Ptr tracksObservation(const vision::TrackedFrame& frame,
                                    const CameraCalibration& calibration, const Pose& T_B_C) {
  auto obs = std::make_shared<CObservationStereoImagesFeatures>();
  obs->sensorLabel = rawlog::kTracksLabel;
  obs->cameraLeft = obs->cameraRight = mrptCamera(calibration);
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
