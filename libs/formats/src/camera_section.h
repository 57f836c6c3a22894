#pragma once
/// What the formats have in common about cameras and IMUs.
#include <optional>
#include <string>
#include <vector>

#include "vir/formats/calibration_file.h"
#include "vir/formats/yaml_section.h"

namespace vir::formats {

/// The model of a lens by any of its names; throws CalibrationError with those that are known.
Distortion distortionOf(const YamlSection& section, const std::string& name);

/// Puts `values` as coefficients of the camera's model, as many as it takes; `key` is named in
/// errors. Those of `omni` are without xi.
void setDistortion(const YamlSection& section, const std::string& key,
                   const std::vector<double>& values, CameraCalibration* camera);

/// Width and height in whole pixels.
void setSize(const YamlSection& section, const std::string& key, double width, double height,
             CameraCalibration* camera);

/// The same where the file has one of the keys; else the size stays 0.
void setSizeIfGiven(const YamlSection& section, const std::string& width, const std::string& height,
                    CameraCalibration* camera);

/// Throws CalibrationError for focal lengths and centres that cannot be.
void checkIntrinsics(const YamlSection& section, const std::string& key,
                     const CameraCalibration& camera);

/// `camera_model`, `intrinsics`, `distortion_model`, `distortion_coeffs` (or `_coefficients`) and
/// `resolution`: Kalibr's and EuRoC's way.
CameraCalibration readListedCamera(const YamlSection& section);

/// How much is added to the stamps of the camera's images [s], where `key` says it. Throws
/// CalibrationError beyond 10 s; notes in `file` what reads as milliseconds.
std::optional<double> readTimeShift(const YamlSection& section, const std::string& key,
                                    CalibrationFile* file);

/// The four densities and the rate, in Kalibr's and EuRoC's names, where all are given and
/// positive.
void readImuNoise(const YamlSection& section, CalibrationFile* file);

/// Notes which cameras lack a pose.
void noteMissingPoses(const std::string& how, CalibrationFile* file);

/// The readers of a format each. `root` is the file.
CalibrationFile readKalibr(const YamlSection& root);
CalibrationFile readOpenVinsConfig(const YamlSection& root);
CalibrationFile readVins(const YamlSection& root);
CalibrationFile readOrbSlam(const YamlSection& root);
CalibrationFile readCameraInfo(const YamlSection& root);
CalibrationFile readSensorYaml(const YamlSection& root);

}  // namespace vir::formats
