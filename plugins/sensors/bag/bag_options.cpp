#include "bag_options.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <sstream>

#include "imu_units.h"
#include "input_error.h"
#include "wishes.h"

namespace vir::bag {
namespace {

constexpr struct {
  const char* name;
  Role role;
} kRoles[] = {{"camera", Role::camera}, {"imu", Role::imu},          {"accel", Role::accelerometer},
              {"gyro", Role::gyro},     {"range", Role::range},      {"peer", Role::peer},
              {"truth", Role::truth},   {"odometry", Role::odometry}};

}  // namespace

void describe(OptionVisitor& v, const std::string& section, BagOptions& o) {
  constexpr double kInf = std::numeric_limits<double>::max();
  v.section(section, section == "bag" ? "Bag of ROS 1, or a folder of its parts"
                                      : "Bag of ROS 2 (folder, .db3, .mcap), MCAP");
  v.value("source", o.source, "the file, or the folder of its parts");
  v.value("topics", o.topics,
          "what to take, as role=/topic or range=/topic:anchor,distance,unit=mm,stamp=field,"
          "sigma=field,valid=field,tag=field,antenna=field,place=field with blanks between; role: "
          "camera imu accel gyro range peer "
          "odometry truth; empty: by the types of messages");
  v.choice("stamps", o.stamps, {"header", "received"},
           "which time holds: the one in the message, or when it was received");
  v.choice("images", o.images, {"files", "embed"}, "images beside the rawlog, or inside");
  v.value("calibration", o.calibration, "file with the calibration of camera and IMU");
  v.value("need_calibration", o.need_calibration,
          "stop where intrinsics or the camera's place on the IMU are not known");
  v.value("levels_16_bit", o.levels_16_bit, 0,
          "black and white of 16-bit images; empty: from the first images, the same for all");
  v.value("width_px", o.width_px, {0, 20000},
          "images are made this wide, calibration included; 0 = as they are");
  v.value("start_s", o.start_s, {0, kInf}, "skip this much after the first message");
  v.value("max_duration_s", o.max_duration_s, {0, kInf}, "stop after this much; 0 = to the end");
  v.value("first_look_s", o.first_look_s, {0.1, kInf},
          "how much of the recording is looked at for topics, calibration and contrast");
  v.choice("acc_unit", o.acc_unit, accelerationUnits(),
           "unit of the accelerometer; auto: m/s2, as messages have it");
  v.choice("gyro_unit", o.gyro_unit, rateUnits(),
           "unit of the gyro; auto: rad/s, as messages have it");
  v.value("imu_time_offset_s", o.imu_time_offset_s, {-4e9, 4e9},
          "stamp of the IMU + this = time on the cameras' clock, to 0.1 s; see stamps as well");
  v.value("range_factor", o.range_factor, {0.1, 10},
          "the ranges are multiplied by this; `vir-slam check` finds it");
  v.value("range_time_offset_s", o.range_time_offset_s, {-4e9, 4e9},
          "of the ranges: stamp + this = time on the IMU's clock; `vir-slam check` finds it");
  v.value("range_sigma_m", o.range_sigma_m, {0, 100}, "of ranges whose messages tell none");
  v.value("lever_arm_m", o.lever_arm_m, 0,
          "antenna in the body frame (the IMU's), of ranges whose messages tell none; or three "
          "numbers for each label, UWB0 UWB1 ...");
}

const char* name(Role role) {
  if (role == Role::told) return "broadcast";
  for (const auto& r : kRoles) {
    if (r.role == role) return r.name;
  }
  return "?";
}

std::vector<TopicWish> parseTopics(const std::string& text) {
  std::vector<TopicWish> wishes;
  const auto is_role = [](const std::string& name) {
    return std::any_of(std::begin(kRoles), std::end(kRoles),
                       [&](const auto& r) { return name == r.name; });
  };
  for (const std::string& word : splitWishes(text, is_role)) {
    const std::size_t equals = word.find('=');
    TopicWish wish;
    bool known = false;
    for (const auto& r : kRoles) {
      if (word.substr(0, equals) == r.name) wish.role = r.role, known = true;
    }
    if (equals == std::string::npos || !known || equals + 1 == word.size()) {
      throw InputError("topic " + word +
                       ": must be role=/topic, role being one of camera imu accel gyro range peer "
                       "odometry truth");
    }
    std::string rest = word.substr(equals + 1);
    if (const std::size_t colon = rest.find(':'); colon != std::string::npos) {
      std::istringstream fields(rest.substr(colon + 1));
      for (std::string f; std::getline(fields, f, ',');) wish.fields.push_back(f);
      rest.resize(colon);
    }
    wish.topic = rest;
    wishes.push_back(wish);
  }
  return wishes;
}

}  // namespace vir::bag
