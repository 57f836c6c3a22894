#include "setup/given_calibration.h"

#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include <algorithm>
#include <cctype>
#include <cstdio>

#include "commands/commands.h"
#include "vir/rawlog/mrpt_camera.h"
#include "vir/rawlog/mrpt_pose.h"

namespace vir::app {
namespace {

std::string assignment(const char* key, double value) {
  char text[96];
  std::snprintf(text, sizeof text, "%s=%.17g", key, value);
  return text;
}

/// Throws when the pixels at hand do not fit.
void requireSize(const mrpt::obs::CObservationImage& image, const CameraCalibration& c,
                 const std::string& path) {
  if (image.image.isExternallyStored() || image.image.isEmpty()) return;
  const auto width = static_cast<int>(image.image.getWidth());
  const auto height = static_cast<int>(image.image.getHeight());
  if (width == c.width && height == c.height) return;
  throw std::runtime_error(path + " is for images of " + std::to_string(c.width) + "x" +
                           std::to_string(c.height) + ", those of " + image.sensorLabel + " have " +
                           std::to_string(width) + "x" + std::to_string(height));
}

}  // namespace

GivenCalibration::GivenCalibration(const std::string& path) {
  if (path.empty()) return;
  requireFile(path, "calibration");
  try {
    file_ = formats::readCalibrationFile(path);
  } catch (const formats::CalibrationError& e) {
    throw UsageError(std::string("--calibration: ") + e.what());
  }
}

const formats::CalibratedCamera* GivenCalibration::cameraFor(const std::string& label,
                                                             const std::string& name) const {
  if (!file_ || file_->cameras.empty()) return nullptr;
  if (label == camera_label_) {
    const formats::CalibratedCamera* named = file_->camera(name);
    return named != nullptr ? named : &file_->cameras.front();
  }
  std::string lower = label;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return file_->camera(lower);
}

void GivenCalibration::apply(mrpt::obs::CObservation* observation) {
  if (!file_) return;
  if (auto* image = dynamic_cast<mrpt::obs::CObservationImage*>(observation)) {
    const formats::CalibratedCamera* c =
        cameraFor(image->sensorLabel, rawlog::nameOf(image->cameraParams));
    if (c == nullptr) return;
    requireSize(*image, c->camera, file_->path);
    image->cameraParams = rawlog::toMrptCamera(c->camera, c->label);
    if (c->T_B_C) image->cameraPose = rawlog::toMrptPose(*c->T_B_C);
  } else if (auto* tracks =
                 dynamic_cast<mrpt::obs::CObservationStereoImagesFeatures*>(observation)) {
    if (file_->cameras.empty()) return;
    const formats::CalibratedCamera& c = file_->cameras.front();
    tracks->cameraLeft = tracks->cameraRight = rawlog::toMrptCamera(c.camera, c.label);
    if (!c.T_B_C) return;
    const auto pose = rawlog::toMrptPose(*c.T_B_C);
    mrpt::math::CQuaternionDouble q;
    pose.getAsQuaternion(q);
    tracks->cameraPoseOnRobot = mrpt::poses::CPose3DQuat(pose.x(), pose.y(), pose.z(), q);
  }
}

std::vector<std::string> GivenCalibration::assignments() const {
  std::vector<std::string> out;
  if (!file_) return out;
  if (file_->imu_noise) {
    const imu::ImuNoise& n = *file_->imu_noise;
    out = {assignment("Imu.gyro_noise_density", n.gyro_noise_density),
           assignment("Imu.gyro_random_walk", n.gyro_random_walk),
           assignment("Imu.acc_noise_density", n.acc_noise_density),
           assignment("Imu.acc_random_walk", n.acc_random_walk)};
  }
  if (!file_->cameras.empty() && file_->cameras.front().time_offset_s) {
    out.push_back(assignment("Camera.time_offset_s", *file_->cameras.front().time_offset_s));
  }
  return out;
}

std::vector<std::string> GivenCalibration::said() const {
  std::vector<std::string> out;
  if (!file_) return out;
  std::string what;
  const auto add = [&](const std::string& part) { what += (what.empty() ? "" : ", ") + part; };
  for (const formats::CalibratedCamera& c : file_->cameras) {
    add("intrinsics of " + c.label);
    if (c.T_B_C) add("its pose on the IMU");
    if (c.time_offset_s) add("its time offset");
  }
  if (file_->imu_noise) add("noise of the IMU");
  out.push_back("calibration from " + file_->path + " (" + file_->format + "): " + what +
                " go before what the recording says");
  for (const std::string& note : file_->notes) out.push_back(file_->path + ": " + note);
  return out;
}

}  // namespace vir::app
