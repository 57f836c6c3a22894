#pragma once
/// Small rawlogs for tests.
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <memory>
#include <string>

#include "vir/core/time.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/rawlog_writer.h"

namespace vir::test {

constexpr TimeNs kStart = 1'700'000'000'000'000'000;
constexpr TimeNs kMs = 1'000'000;

inline std::shared_ptr<mrpt::obs::CObservationIMU> imuAt(TimeNs t) {
  auto imu = std::make_shared<mrpt::obs::CObservationIMU>();
  imu->timestamp = rawlog::toMrptTime(t);
  imu->sensorLabel = "IMU0";
  imu->set(mrpt::obs::IMU_Z_ACC, 9.81);
  return imu;
}

/// 16 x 12 pixels, embedded; the first one is `value`.
inline std::shared_ptr<mrpt::obs::CObservationImage> imageAt(TimeNs t, int value = 0) {
  auto image = std::make_shared<mrpt::obs::CObservationImage>();
  image->timestamp = rawlog::toMrptTime(t);
  image->sensorLabel = "CAM0";
  image->image.resize(16, 12, mrpt::img::CH_GRAY);
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 16; ++x) *image->image.ptr<std::uint8_t>(x, y) = 0;
  }
  *image->image.ptr<std::uint8_t>(0, 0) = static_cast<std::uint8_t>(value);
  return image;
}

inline std::shared_ptr<mrpt::obs::CObservationRobotPose> truthAt(TimeNs t, double x) {
  auto pose = std::make_shared<mrpt::obs::CObservationRobotPose>();
  pose->timestamp = rawlog::toMrptTime(t);
  pose->sensorLabel = "GT";
  pose->pose.mean = mrpt::poses::CPose3D(x, 0, 0, 0, 0, 0);
  return pose;
}

inline std::shared_ptr<mrpt::obs::CObservationBeaconRanges> rangeAt(TimeNs t, int anchor) {
  auto range = std::make_shared<mrpt::obs::CObservationBeaconRanges>();
  range->timestamp = rawlog::toMrptTime(t);
  range->sensorLabel = "UWB0";
  range->sensedData.emplace_back();
  range->sensedData.back().beaconID = anchor;
  range->sensedData.back().sensedDistance = 3;
  return range;
}

inline std::shared_ptr<mrpt::obs::CObservationRobotPose> odometryAt(TimeNs t, double x) {
  const auto pose = truthAt(t, x);
  pose->sensorLabel = "ODOM";
  return pose;
}

/// `images` images at 20 Hz, IMU at 200 Hz around them, ground truth with each image (0.1 m along x
/// per image).
inline void writeRecording(const std::string& path, int images) {
  rawlog::RawlogWriter writer(path);
  for (int i = 0; i < 10 * images; ++i) {
    const TimeNs t = kStart + 5 * i * kMs;
    writer.write(*imuAt(t));
    if (i % 10 != 5) continue;
    writer.write(*imageAt(t, i / 10));
    writer.write(*truthAt(t, 0.1 * (i / 10)));
  }
  writer.finish();
}

}  // namespace vir::test
