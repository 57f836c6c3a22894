#pragma once
/// Which topics become which streams of the rawlog.
#include <optional>
#include <string>
#include <vector>

#include "bag_options.h"
#include "problem_log.h"
#include "range_fields.h"
#include "survey.h"

namespace vir::bag {

struct Stream {
  Role role = Role::camera;
  std::string topic, type, label;
  std::string anchor_name;    ///< of the anchor in `label`, where that is no number that fits
  Vec3 p_B_U = Vec3::Zero();  ///< of another robot that tells its pose: its antenna in its body [m]
  std::size_t camera = 0;     ///< number of the camera
  std::size_t antenna = 0;    ///< number of the label of ranges
  RangeFields range;
  /// Truth and odometry: our body (the IMU) in the frame whose pose the topic gives.
  Pose T_F_B;
  bool position_only = false;
};

struct Choice {
  std::vector<Stream> streams;
  std::string imu_frame;
};

/// What `wishes` ask for, and without any what the types of the messages suggest; says in `log`
/// what was taken and what was not. Throws InputError that names the topics there are, and
/// formats::CalibrationError for options.calibration.
Choice chooseTopics(const Survey& survey, const BagOptions& options,
                    const std::vector<TopicWish>& wishes, ProblemLog* log);

}  // namespace vir::bag
