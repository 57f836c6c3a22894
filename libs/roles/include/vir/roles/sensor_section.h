#pragma once
/// What the acquisition itself reads in the section of a sensor, and does to its observations.
#include <mrpt/obs/CObservation.h>

#include <string>
#include <vector>

#include "vir/core/settings.h"
#include "vir/core/time.h"

namespace vir::roles {

struct SensorSection {
  std::string name, driver;
  double rate_hz = 0;
  bool optional = false;
  std::string clock = "auto";
  double stamp_offset_s = 0;
  // Of a camera whose driver leaves them empty.
  std::vector<double> intrinsics;  ///< fx fy cx cy [px]
  std::string distortion = "none";
  std::vector<double> dist;
  std::vector<double> camera_pose;  ///< x y z [m] yaw pitch roll [deg] in the body
};

/// Keys that a driver's own reader must let pass (readGrabberSection).
const std::vector<std::string>& acquisitionKeys();

/// Throws SettingsError: a value that cannot be, process_rate missing.
SensorSection readSensorSection(const Settings& settings, const std::string& section);

/// Fills in what the driver left empty and moves the stamp by stamp_offset_s.
void complete(const SensorSection& section, mrpt::obs::CObservation* observation);

}  // namespace vir::roles
