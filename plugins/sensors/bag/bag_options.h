#pragma once
#include <string>
#include <vector>

#include "vir/core/options.h"

namespace vir::bag {

/// Settings of sections [bag] and [rosbag2].
struct BagOptions {
  std::string source;             ///< file or folder
  std::string topics;             ///< `role=/topic[:field,...]` with blanks between; empty: by type
  std::string stamps = "header";  ///< header or received
  std::string images = "files";   ///< files or embed
  std::string calibration;        ///< file; empty: what the recording says of itself
  bool need_calibration = true;
  std::vector<double> levels_16_bit;  ///< black and white; empty: from the first images
  int width_px = 0;                   ///< images are made this wide; 0: as they are
  double start_s = 0;                 ///< [s] after the first message
  double max_duration_s = 0;          ///< [s] from the start, 0 = all
  double first_look_s = 10;           ///< how much is looked at before the import begins

  std::string acc_unit = "auto", gyro_unit = "auto";  ///< words of imu_units.h

  double imu_time_offset_s = 0;    ///< stamp of a reading + this = time on the cameras' clock
  double range_factor = 1;         ///< on the ranges
  double range_time_offset_s = 0;  ///< stamp of a range + this = time on the IMU's clock
  double range_sigma_m = 0.1;
  std::vector<double> lever_arm_m{0, 0, 0};  ///< antenna in body
};

/// `section`: the driver's name.
void describe(OptionVisitor& v, const std::string& section, BagOptions& o);

/// `told`: what another robot said of itself, or where an anchor was put down; of our own files
/// only.
enum class Role { camera, imu, accelerometer, gyro, range, peer, truth, odometry, told };
const char* name(Role role);

/// What somebody asked for with `--topic`.
struct TopicWish {
  Role role = Role::camera;
  std::string topic;
  std::vector<std::string> fields;
};

/// Throws InputError for text of another form, naming it and what is known.
std::vector<TopicWish> parseTopics(const std::string& text);

}  // namespace vir::bag
