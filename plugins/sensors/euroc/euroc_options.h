#pragma once
#include <string>
#include <vector>

#include "vir/core/options.h"

namespace vir::euroc {

/// Settings of section [euroc], and of [csv].
struct EurocOptions {
  std::string section = "euroc";
  std::string source;           ///< folder with `mav0`, or `mav0` itself; [csv]: any folder
  std::string topics;           ///< [csv] only: ROLE=FILE, with blanks between
  std::string camera = "cam0";  ///< folder below mav0, or "none"
  bool other_cameras = true;    ///< CAM1, ... too
  std::string calibration;      ///< file; empty: the sensor.yaml files of the recording
  std::string images = "link";  ///< link, copy or embed
  bool read_gt = true;
  bool read_ranges = true;
  std::string antenna;  ///< only its ranges, where a column names antennas; empty: all
  std::string acc_unit = "auto", gyro_unit = "auto", range_unit = "auto";
  int width_px = 0;  ///< images are made this wide; 0: as they are
  /// [csv] only: when the first frame of a video was taken, on the IMU's clock [s]; "auto": see
  /// startOfVideo(). Text, since a double is too coarse for dates.
  std::string video_start = "auto";
  std::string turn_video = "0";  ///< [csv] only: its frames, clockwise [deg]
  double start_s = 0;            ///< [s] after the first image
  double max_duration_s = 0;     ///< [s] from the start, 0 = all

  double imu_time_offset_s = 0;    ///< stamp of a reading + this = time on the cameras' clock
  double range_factor = 1;         ///< on the ranges read
  double range_time_offset_s = 0;  ///< stamp of a range read + this = time on the IMU's clock
  bool simulate_ranges = false;
  std::vector<double> anchor_m;   ///< x y z of each anchor in the ground truth's world [m]
  std::vector<double> anchor_id;  ///< one per anchor; empty: 0, 1, 2, ...
  double range_sigma_m = 0.05;
  double range_rate_hz = 20;                 ///< per anchor
  std::vector<double> lever_arm_m{0, 0, 0};  ///< antenna in body
  int range_seed = 1;
  double nlos_share = 0;  ///< 0..1
  double nlos_min_m = 0.5;
  double nlos_max_m = 2.0;
};

void describe(OptionVisitor& v, EurocOptions& o);

/// Checks that go beyond one value. Throws InputError naming key, value and what is allowed.
void validate(const EurocOptions& o);

}  // namespace vir::euroc
