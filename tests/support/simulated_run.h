#pragma once
/// One run of the estimator on simulated tracks, readings and ranges, and how good it was.
#include <Eigen/Dense>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "vir/estimator/visual_inertial_estimator.h"
#include "vir/evaluation/evaluate.h"
#include "vir/simulation/simulate_imu.h"
#include "vir/simulation/simulate_ranges.h"
#include "vir/simulation/track_simulator.h"

namespace vir::tool {

struct RunSettings {
  estimator::EstimatorConfig estimator;
  simulation::ImuSimulationOptions imu;
  simulation::TrackSimulationOptions tracks;
  simulation::RangeSimulationOptions ranges;
  CameraCalibration camera;
  Pose T_B_C;
  std::optional<Pose> given_T_B_C;  ///< what the estimator is told of it, where that is wrong
  /// Likewise of the camera: the pixels are those of `camera`.
  std::optional<CameraCalibration> given_camera;
  bool use_ranges = false;
  /// Readings of the IMU from here to there after the begin are missing [s].
  std::pair<double, double> silent_imu_s{0, 0};
  /// In this stretch the camera repeats what it saw at its start [s].
  std::pair<double, double> frozen_camera_s{0, 0};
  /// In this stretch the IMU reads what it does not feel.
  std::pair<double, double> false_imu_s{0, 0};
  std::function<ImuSample(const ImuSample&)> false_imu;
  /// In this stretch every 20th image and the next exchange their stamps.
  std::pair<double, double> swapped_images_s{0, 0};
  double images_late_s = 0;     ///< how much later than they were taken images are stamped
  double camera_clock_ppm = 0;  ///< how much faster than the IMU's clock the camera's runs
  std::FILE* log = nullptr;     ///< what the estimator says goes there
};

/// The estimate at one image against the truth, in the truth's world after the estimate has been
/// laid onto it by position and yaw of its first keyframe: the gauge of the estimator's covariance.
struct PoseError {
  TimeNs t = 0;
  Vec3 position = Vec3::Zero();  ///< estimate - truth [m]
  double rotation_rad = 0, yaw_rad = 0;
  Vec3 sigma = Vec3::Zero();  ///< claimed standard deviation; 0 = none claimed
  double nees = -1;           ///< of the position, 3 degrees of freedom; -1 = none
  int tracks = 0, landmarks = 0;
  std::string health;
};

struct AnchorError {
  int id = 0;
  bool found = false;
  double error_m = 0;        ///< after the alignment of the causal trajectory
  double error_first_m = 0;  ///< in the gauge of the first keyframe
  double horizontal_m = 0;   ///< of error_m
  double nees = -1;          ///< in the gauge of the first keyframe, 3 degrees of freedom
  std::string state;
};

struct RunResult {
  int seed = 0;
  bool valid = false;  ///< false: never started
  std::string note;
  evaluation::EvaluationResult evaluation;  ///< causal trajectory, position and yaw aligned
  Trajectory estimate, truth;
  std::vector<PoseError> errors;
  std::vector<AnchorError> anchors;
  double init_s = 0;  ///< from the first image to the first pose
  double mean_nees = -1;
  double end_error_m = 0;     ///< in the gauge of the first keyframe
  double largest_jump_m = 0;  ///< change of the position error from one image to the next
  double ms_per_frame = 0;
  double mean_tracks = 0;
  int resets = 0;
  std::vector<std::string> doubts, warnings;
  estimator::EstimatorCounters counters;
  Calibration calibration;  ///< as it was found
  long ranges = 0;
  double smoothed_ate_m = -1;             ///< of the keyframes as last seen
  std::map<std::string, long> decisions;  ///< what became of the ranges
};

RunResult simulateRun(const std::shared_ptr<const simulation::Motion>& motion, RunSettings settings,
                      int seed);

}  // namespace vir::tool
