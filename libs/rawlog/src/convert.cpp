#include "vir/rawlog/convert.h"

#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "beacon_measurements.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_camera.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/rawlog_reader.h"

namespace vir::rawlog {

using namespace mrpt::obs;

std::optional<ImuSample> imuSampleOf(const CObservation& observation) {
  const auto* imu = dynamic_cast<const CObservationIMU*>(&observation);
  if (imu == nullptr) return std::nullopt;
  for (const auto index : {IMU_X_ACC, IMU_Y_ACC, IMU_Z_ACC, IMU_WX, IMU_WY, IMU_WZ}) {
    if (!imu->has(index)) return std::nullopt;
  }
  ImuSample s;
  s.t = fromMrptTime(imu->timestamp);
  s.acc = Vec3(imu->get(IMU_X_ACC), imu->get(IMU_Y_ACC), imu->get(IMU_Z_ACC));
  s.gyro = Vec3(imu->get(IMU_WX), imu->get(IMU_WY), imu->get(IMU_WZ));
  return s;
}

CObservationIMU::Ptr toObservation(const ImuSample& sample, const std::string& label) {
  auto o = CObservationIMU::Create();
  o->sensorLabel = label;
  o->timestamp = toMrptTime(sample.t);
  o->set(IMU_X_ACC, sample.acc.x());
  o->set(IMU_Y_ACC, sample.acc.y());
  o->set(IMU_Z_ACC, sample.acc.z());
  o->set(IMU_WX, sample.gyro.x());
  o->set(IMU_WY, sample.gyro.y());
  o->set(IMU_WZ, sample.gyro.z());
  return o;
}

std::vector<Range> rangesOf(const CObservation& observation) {
  if (differenceReferenceOf(observation.sensorLabel)) return {};
  return beaconMeasurements(observation);
}

std::vector<Range> beaconMeasurements(const CObservation& observation) {
  std::vector<Range> out;
  const auto* o = dynamic_cast<const CObservationBeaconRanges*>(&observation);
  if (o == nullptr) return out;
  for (const auto& m : o->sensedData) {
    const auto& p = m.sensorLocationOnRobot;
    Range r;
    r.t = fromMrptTime(o->timestamp);
    r.anchor = static_cast<std::uint32_t>(m.beaconID);
    r.range_m = static_cast<double>(m.sensedDistance);
    r.sigma_m = static_cast<double>(o->stdError);
    r.p_B_U = Vec3(p.x(), p.y(), p.z());
    out.push_back(r);
  }
  return out;
}

CObservationBeaconRanges::Ptr toObservation(const Range& range, const std::string& label,
                                            const RadioReach& reach) {
  auto o = CObservationBeaconRanges::Create();
  o->sensorLabel = label;
  o->timestamp = toMrptTime(range.t);
  o->minSensorDistance = static_cast<float>(reach.min_m);
  o->maxSensorDistance = static_cast<float>(reach.max_m);
  o->stdError = static_cast<float>(range.sigma_m);
  CObservationBeaconRanges::TMeasurement m;
  m.beaconID = static_cast<std::int32_t>(range.anchor);
  m.sensedDistance = static_cast<float>(range.range_m);
  m.sensorLocationOnRobot =
      mrpt::poses::CPoint3D(range.p_B_U.x(), range.p_B_U.y(), range.p_B_U.z());
  o->sensedData.push_back(m);
  return o;
}

std::optional<StampedPose> poseOf(const CObservation& observation) {
  const auto* o = dynamic_cast<const CObservationRobotPose*>(&observation);
  if (o == nullptr) return std::nullopt;
  return StampedPose{fromMrptTime(o->timestamp), fromMrptPose(o->pose.mean)};
}

CObservationRobotPose::Ptr toObservation(const StampedPose& pose, const std::string& label) {
  auto o = CObservationRobotPose::Create();
  o->sensorLabel = label;
  o->timestamp = toMrptTime(pose.t);
  o->pose.mean = toMrptPose(pose.T_W_B);
  o->pose.cov.setZero();
  return o;
}

std::optional<DeployedAnchor> deployedAnchorOf(const CObservation& observation) {
  const auto id = deployedAnchorOf(observation.sensorLabel);
  const auto* o = dynamic_cast<const CObservationRobotPose*>(&observation);
  if (!id || o == nullptr) return std::nullopt;
  DeployedAnchor out;
  out.id = *id;
  const auto& mean = o->pose.mean;
  out.p_B = Vec3(mean.x(), mean.y(), mean.z());
  double variance = 0;
  for (int i = 0; i < 3; ++i) variance = std::max(variance, o->pose.cov(i, i));
  if (variance > 0 && std::isfinite(variance)) out.sigma_m = std::sqrt(variance);
  if (!out.p_B.allFinite()) return std::nullopt;
  return out;
}

std::optional<PeerBroadcast> broadcastOf(const CObservation& observation,
                                         const std::string& peer_label) {
  const auto source = broadcastSourceOf(observation.sensorLabel, peer_label);
  const auto* o = dynamic_cast<const CObservationRobotPose*>(&observation);
  if (!source || source->world || o == nullptr) return std::nullopt;
  PeerBroadcast out{source->peer, source->anchor, {}};
  const auto& mean = o->pose.mean;
  out.sent.t = fromMrptTime(o->timestamp);
  out.sent.p_W = Vec3(mean.x(), mean.y(), mean.z());
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) out.sent.covariance(r, c) = o->pose.cov(r, c);
  }
  return out;
}

CObservationRobotPose::Ptr toObservation(const PeerBroadcast& broadcast,
                                         const std::string& peer_label) {
  auto o = CObservationRobotPose::Create();
  o->sensorLabel = broadcastLabel({broadcast.peer, broadcast.anchor}, peer_label);
  o->timestamp = toMrptTime(broadcast.sent.t);
  const Vec3& p = broadcast.sent.p_W;
  o->pose.mean = mrpt::poses::CPose3D(p.x(), p.y(), p.z(), 0, 0, 0);
  o->pose.cov.setZero();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) o->pose.cov(r, c) = broadcast.sent.covariance(r, c);
  }
  return o;
}

std::optional<PeerPose> peerPoseOf(const CObservation& observation, const std::string& peer_label) {
  const auto source = broadcastSourceOf(observation.sensorLabel, peer_label);
  const auto* o = dynamic_cast<const CObservationRobotPose*>(&observation);
  if (!source || !source->world || o == nullptr) return std::nullopt;
  PeerPose out;
  out.peer = source->peer;
  out.world = *source->world;
  out.t = fromMrptTime(o->timestamp);
  out.T_W_B = fromMrptPose(o->pose.mean);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) out.covariance(r, c) = o->pose.cov(r, c);
  }
  out.p_B_U = Vec3(o->sensorPose.x(), o->sensorPose.y(), o->sensorPose.z());
  return out;
}

CObservationRobotPose::Ptr toObservation(const PeerPose& pose, const std::string& peer_label) {
  auto o = CObservationRobotPose::Create();
  o->sensorLabel = broadcastLabel({pose.peer, std::nullopt, pose.world}, peer_label);
  o->timestamp = toMrptTime(pose.t);
  o->pose.mean = toMrptPose(pose.T_W_B);
  o->pose.cov.setZero();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) o->pose.cov(r, c) = pose.covariance(r, c);
  }
  o->sensorPose = mrpt::poses::CPose3D(pose.p_B_U.x(), pose.p_B_U.y(), pose.p_B_U.z(), 0, 0, 0);
  return o;
}

std::optional<Calibration> calibrationOf(const CObservation& observation) {
  const auto* image = dynamic_cast<const CObservationImage*>(&observation);
  if (image == nullptr) return {};
  Calibration out;
  out.T_B_C = fromMrptPose(image->cameraPose);
  out.camera = fromMrptCamera(image->cameraParams);
  return out;
}

Calibration calibrationIn(const std::string& rawlog, const std::string& camera_label,
                          const std::function<void(CObservation*)>& given) {
  RawlogReader reader(rawlog);
  while (const auto observation = reader.next()) {
    if (observation->sensorLabel != camera_label) continue;
    if (given) given(observation.get());
    if (const auto calibration = calibrationOf(*observation)) return *calibration;
  }
  throw std::runtime_error("there is no image labelled " + camera_label + " in " + rawlog);
}

bool isImage(const CObservation& observation) {
  return dynamic_cast<const CObservationImage*>(&observation) != nullptr ||
         dynamic_cast<const CObservationStereoImagesFeatures*>(&observation) != nullptr;
}

}  // namespace vir::rawlog
