#include "sensor_yaml.h"

#include "input_error.h"
#include "vir/formats/calibration_file.h"
#include "vir/formats/yaml_section.h"

namespace vir::euroc {
namespace {

using formats::YamlSection;

/// What is wrong with a calibration is wrong with the recording.
template <typename Read>
auto asInput(Read read) {
  try {
    return read();
  } catch (const formats::CalibrationError& e) {
    throw InputError(e.what());
  }
}

Pose poseOf(const YamlSection& root) { return root.has("T_BS") ? root.pose("T_BS") : Pose(); }

}  // namespace

CameraYaml readCameraYaml(const std::string& path) {
  return asInput([&] {
    const formats::CalibrationFile file = formats::readCalibrationFile(path);
    if (file.cameras.empty()) throw InputError(path + ": holds no camera");
    const formats::CalibratedCamera& c = file.cameras.front();
    return CameraYaml{c.camera, c.T_B_C.value_or(Pose()), c.T_B_C.has_value()};
  });
}

GivenCalibration readGivenCalibration(const std::string& path, const std::string& camera,
                                      bool or_first) {
  if (path.empty()) return {};
  return asInput([&] {
    const formats::CalibrationFile file = formats::readCalibrationFile(path);
    GivenCalibration given;
    given.notes = file.notes;
    const formats::CalibratedCamera* c = file.camera(camera);
    if (c == nullptr && or_first && !file.cameras.empty()) c = &file.cameras.front();
    if (c != nullptr) {
      given.camera = c->camera;
      given.T_B_C = c->T_B_C;
      given.time_offset_s = c->time_offset_s;
    }
    if (file.imu_noise) {
      const imu::ImuNoise& n = *file.imu_noise;
      given.imu = ImuYaml{n.gyro_noise_density,
                          n.gyro_random_walk,
                          n.acc_noise_density,
                          n.acc_random_walk,
                          true,
                          {}};
    }
    return given;
  });
}

ImuYaml readImuYaml(const std::string& path, ProblemLog* log) {
  return asInput([&] {
    const YamlSection root = YamlSection::load(path);
    const auto density = [&](const char* key) { return root.optionalNumber(key).value_or(0); };
    ImuYaml imu;
    imu.T_B_I = poseOf(root);
    imu.gyro_noise_density = density("gyroscope_noise_density");
    imu.gyro_random_walk = density("gyroscope_random_walk");
    imu.acc_noise_density = density("accelerometer_noise_density");
    imu.acc_random_walk = density("accelerometer_random_walk");
    imu.has_noise = imu.gyro_noise_density > 0 && imu.gyro_random_walk > 0 &&
                    imu.acc_noise_density > 0 && imu.acc_random_walk > 0;
    if (!imu.has_noise) {
      log->note(path +
                ": not all four noise densities are given and positive; none is passed on, the "
                "estimator's defaults hold");
    }
    return imu;
  });
}

UwbYaml readUwbYaml(const std::string& path) {
  return asInput([&] {
    const YamlSection root = YamlSection::load(path);
    if (!root.has("T_BS")) throw InputError(path + ": `T_BS` (sensor to body, 4x4) is missing");
    UwbYaml uwb;
    uwb.T_B_U = root.pose("T_BS");
    uwb.sigma_m = root.optionalNumber("range_noise_sigma");
    if (uwb.sigma_m && *uwb.sigma_m <= 0) {
      throw InputError(path + ": `range_noise_sigma` must be positive");
    }
    return uwb;
  });
}

Pose readSensorPose(const std::string& path) {
  return asInput([&] { return poseOf(YamlSection::load(path)); });
}

}  // namespace vir::euroc
