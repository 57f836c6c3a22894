#pragma once
#include <map>
#include <string>
#include <vector>

#include "vir/camera/camera_model.h"
#include "vir/rendering/camera_simulator.h"
#include "vir/rendering/make_scene.h"
#include "vir/simulation/flights.h"
#include "vir/simulation/simulate_imu.h"
#include "vir/simulation/simulate_team_ranges.h"
#include "vir/simulation/track_simulator.h"

namespace vir::simulator {

/// Where one robot goes: section [Robot_A] for robot A.
struct RobotOptions {
  std::string flight = "eight";  ///< name of a made-up flight
  std::string trajectory;        ///< a file with poses to fly again instead
  double from_s = 0;             ///< of the file
  double duration_s = 0;         ///< the file is flown, or the flight cut, for so long; 0 = all
  double length_m = 0;           ///< of the flight; 0 = as [Flight] says
  double speed_mps = 0;          ///< the same
  std::vector<double> start_m{0, 0, 0};
  double start_heading_deg = 0;
};

/// A camera that all robots carry: section [Camera], and [Camera1], ... of further ones.
struct CameraOptions {
  double rate_hz = 20;
  double phase_s = 0.0023;   ///< of the first image after the first IMU reading
  double time_offset_s = 0;  ///< stamp of an image + this = time on the IMU's clock
  /// Rolling shutter: time from the first row to the last, the middle one is seen at the image's
  /// time; 0 = all at once.
  double readout_s = 0;
  int width = 752, height = 480;
  double fx_px = 458.654, fy_px = 457.296, cx_px = 367.215, cy_px = 248.375;
  std::string distortion = "radtan";
  std::vector<double> dist{-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0};
  std::string mount = "forward";  ///< forward, backward, left, right, down, euroc
  double tilt_deg = 0;            ///< downwards, of `forward`
  std::vector<double> position_m{0.05, 0.02, -0.01};  ///< in the body
  // What the recording says of the camera is not quite what it is, as with every calibration.
  double focal_error = 0.0005;    ///< standard deviation, share of the focal length
  double center_error_px = 0.3;   ///< standard deviation per axis
  double mount_error_deg = 0.05;  ///< standard deviation per axis of its attitude
  double mount_error_m = 0;       ///< standard deviation per axis of its place
  double clock_error_s = 0;       ///< its offset is this much more than `time_offset_s` says
  // Faults, from to, from to ... since the recording's begin [s].
  std::vector<double> black_s;      ///< images without any light
  std::vector<double> frozen_s;     ///< the image before it, again and again
  std::vector<double> missing_s;    ///< no images
  std::vector<double> half_rate_s;  ///< every second image only

  /// Stamp of an image + this = time on the IMU's clock, as it is.
  double trueOffset() const { return time_offset_s + clock_error_s; }
};

/// Everything about a simulated world; section [simulator] and those of its parts.
struct SimulatorOptions {
  SimulatorOptions() {
    // Errors of a factory calibration; with those of the camera an estimator drifts as it does on
    // real flights (docs/simulation.md).
    imu.scale_error = imu.misalignment_rad = 0.002;
  }
  std::string robots = "A";  ///< letters with blanks between
  std::string robot;         ///< whose recording it is; empty = the first
  std::string images = "external";
  std::string image_format = "jpg";
  int jpeg_quality = 90;
  bool tracks = false, ranges = true, read_gt = true, odometry = false;
  double gt_rate_hz = 100;
  double start_time_s = 1600000000;
  int seed = 0;  ///< added to all seeds
  int cameras = 1;
  CameraOptions camera;
  std::vector<CameraOptions> further_cameras;  ///< `cameras` less one
  simulation::FlightOptions flight;
  std::map<char, RobotOptions> robot_options;
  rendering::SceneOptions scene;
  rendering::CameraSimulationOptions camera_effects;
  simulation::ImuSimulationOptions imu;
  simulation::TrackSimulationOptions track_errors;
  simulation::RangeSimulationOptions range_errors;
  simulation::TeamRangeOptions team;
  simulation::OdometrySimulationOptions odometry_errors;
};

/// `robots` and `cameras` are read first: they say which sections [Robot_?], [Camera?] there are.
void describe(OptionVisitor& v, SimulatorOptions& o);

/// The letters of `robots`. Throws SettingsError for anything but single letters, each once.
std::vector<char> lettersOf(const SimulatorOptions& o);
/// The letter of the robot whose recording it is. Throws SettingsError if there is no such robot.
char recordedRobot(const SimulatorOptions& o);
/// A and a = 0 ... Z and z = 25.
int robotId(char letter);

/// As the recording says.
CameraCalibration calibrationOf(const CameraOptions& o);
/// Camera in the body, as the recording says.
Pose mountOf(const CameraOptions& o);

struct TrueCamera {
  CameraCalibration calibration;
  Pose T_B_C;
};
/// As it is.
TrueCamera trueCamera(const CameraOptions& o, int seed);

}  // namespace vir::simulator
