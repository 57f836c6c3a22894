#pragma once
/// What the acquisition itself reads in the section of a sensor, and does to its observations.
#include <mrpt/obs/CObservation.h>

#include <string>
#include <utility>
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
  /// Its images hold the views of two cameras, the left one's on the left.
  bool side_by_side = false;
  // Of the right one of two cameras, as above; the lens as the left one's where empty.
  std::vector<double> right_intrinsics, right_dist, right_camera_pose;
};

/// Keys that a driver's own reader must let pass (readGrabberSection).
const std::vector<std::string>& acquisitionKeys();

/// Throws SettingsError: a value that cannot be, process_rate missing.
SensorSection readSensorSection(const Settings& settings, const std::string& section);

/// Fills in what the driver left empty and moves the stamp by stamp_offset_s. `right`: an image of
/// the right one of two cameras.
void complete(const SensorSection& section, mrpt::obs::CObservation* observation,
              bool right = false);

/// One observation, or the images of two cameras where the driver gives both in one: pairs
/// (CObservationStereoImages) and, where the section says so, views side by side. Second: is it of
/// the right camera? Throws std::invalid_argument if an image cannot be taken apart.
std::vector<std::pair<mrpt::obs::CObservation::Ptr, bool>> takenApart(
    const SensorSection& section, const mrpt::obs::CObservation::Ptr& observation);

}  // namespace vir::roles
