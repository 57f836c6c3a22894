#include "setup/given_calibration.h"

#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include <filesystem>

#include "commands/commands.h"
#include "vir/check/intrinsics_check.h"
#include "vir/core/text.h"
#include "vir/rawlog/mrpt_camera.h"
#include "vir/rawlog/mrpt_pose.h"

namespace vir::app {
namespace {

constexpr const char* kSection = "Estimator";
constexpr const char* kKey = "calibration";

/// Each of them.
std::string absolutePaths(const std::vector<std::string>& paths) {
  std::string out;
  for (const std::string& path : paths) {
    if (!out.empty()) out += formats::kPathSeparator;
    out += std::filesystem::absolute(path).lexically_normal().string();
  }
  return out;
}

void sizeFrom(int width, int height, const std::string& path, CameraCalibration* c) {
  try {
    formats::takeSizeOfImages(width, height, c);
  } catch (const formats::CalibrationError& e) {
    throw std::runtime_error(path + ": " + e.what());
  }
}

/// With the size that the recording, or else the pixels, say, where the file says none.
CameraCalibration withSize(const mrpt::obs::CObservationImage& image, CameraCalibration c,
                           const std::string& path) {
  if (c.width > 0) return c;
  const bool said = image.cameraParams.ncols > 0 && image.cameraParams.nrows > 0;
  const auto width = said ? image.cameraParams.ncols : image.image.getWidth();
  const auto height = said ? image.cameraParams.nrows : image.image.getHeight();
  sizeFrom(static_cast<int>(width), static_cast<int>(height), path, &c);
  return c;
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

void requireCalibration(const std::string& paths) {
  for (const std::string& path : formats::calibrationPaths(paths)) requireFile(path, "calibration");
}

GivenCalibration::GivenCalibration(const std::string& path) {
  if (path.empty()) return;
  requireCalibration(path);
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
  return file_->camera(lowerCase(label));
}

void GivenCalibration::apply(mrpt::obs::CObservation* observation) {
  if (!file_) return;
  if (auto* image = dynamic_cast<mrpt::obs::CObservationImage*>(observation)) {
    const formats::CalibratedCamera* c =
        cameraFor(image->sensorLabel, rawlog::nameOf(image->cameraParams));
    if (c == nullptr) return;
    const CameraCalibration camera = withSize(*image, c->camera, file_->path);
    requireSize(*image, camera, file_->path);
    image->cameraParams = rawlog::toMrptCamera(camera, c->label);
    if (c->T_B_C) image->cameraPose = rawlog::toMrptPose(*c->T_B_C);
  } else if (auto* tracks =
                 dynamic_cast<mrpt::obs::CObservationStereoImagesFeatures*>(observation)) {
    if (file_->cameras.empty()) return;
    formats::CalibratedCamera c = file_->cameras.front();
    if (c.camera.width == 0) {
      sizeFrom(static_cast<int>(tracks->cameraLeft.ncols),
               static_cast<int>(tracks->cameraLeft.nrows), file_->path, &c.camera);
    }
    tracks->cameraLeft = tracks->cameraRight = rawlog::toMrptCamera(c.camera, c.label);
    if (!c.T_B_C) return;
    const auto pose = rawlog::toMrptPose(*c.T_B_C);
    mrpt::math::CQuaternionDouble q;
    pose.getAsQuaternion(q);
    tracks->cameraPoseOnRobot = mrpt::poses::CPose3DQuat(pose.x(), pose.y(), pose.z(), q);
  }
}

std::vector<std::string> GivenCalibration::assignments() const {
  return file_ ? formats::settingsOf(*file_) : std::vector<std::string>();
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
    if (c.readout_s) add("its readout");
  }
  if (file_->imu_noise) add("noise of the IMU");
  if (file_->imu_correction) add("gains and axes of the IMU");
  out.push_back("calibration from " + file_->path + " (" + file_->format + "): " + what +
                " go before what the recording says");
  for (const formats::CalibratedCamera& c : file_->cameras) {
    if (!c.T_B_C) continue;
    const auto far = check::mountingFinding(c.T_B_C->p.norm(), c.label);
    if (far) out.push_back(file_->path + ": " + check::line(*far));
  }
  for (const std::string& note : file_->notes) out.push_back(file_->path + ": " + note);
  return out;
}

GivenCalibration takeCalibration(const std::string& path, const std::vector<std::string>& set,
                                 Settings* settings) {
  const std::string key = std::string(kSection) + "." + kKey + "=";
  const GivenCalibration given(path);
  for (const std::string& assignment : given.assignments()) settings->set(assignment);
  if (!path.empty()) settings->set(key + absolutePaths(formats::calibrationPaths(path)));
  for (const std::string& assignment : set) settings->set(assignment);
  const Setting* named = settings->find(kSection, kKey);
  if (named == nullptr || named->value.empty() || !path.empty()) return given;

  std::string folder;  // that its paths are below
  if (named->origin.line > 0) {
    folder = std::filesystem::path(settings->name()).parent_path().string();
  }
  const std::string files = absolutePaths(formats::calibrationPaths(named->value, folder));
  const GivenCalibration of_ini(files);
  Settings rest;
  for (const std::string& assignment : of_ini.assignments()) rest.set(assignment);
  settings->mergeDefaults(rest);
  settings->set(key + files);
  return of_ini;
}

}  // namespace vir::app
