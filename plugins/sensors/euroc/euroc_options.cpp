#include "euroc_options.h"

#include <cmath>
#include <limits>
#include <set>

#include "imu_units.h"
#include "input_error.h"
#include "lever_arms.h"
#include "vir/tables/stamps.h"

namespace vir::euroc {

void describe(OptionVisitor& v, EurocOptions& o) {
  constexpr double kInf = std::numeric_limits<double>::max();
  const bool tables = o.section == "csv";
  if (tables) {
    v.section("csv", "Folder of tables (csv, txt) and images, whatever they are called");
    v.value("source", o.source, "the folder, or a video beside its tables");
    v.value("topics", o.topics,
            "ROLE=FILE with blanks between; roles: imu, accel, gyro, camera (a list, a folder or a "
            "video), times (of a video's frames), range, anchor_range (between anchors), truth; "
            "ROLE=none "
            "leaves one out; empty: "
            "found by headers and names");
    v.value(
        "video_start", o.video_start,
        "time of a video's first frame on the IMU's clock [s], where no table says the times of "
        "its frames; auto: 0 if the IMU's clock begins with the video, else the IMU's first");
    v.choice("turn_video", o.turn_video, {"0", "90", "180", "270"},
             "turn a video's frames clockwise; what its file says of turning is not followed");
  } else {
    v.section("euroc", "Recording in the EuRoC (ASL) folder layout, TUM-VI included");
    v.value("source", o.source, "folder that contains mav0, or mav0 itself");
    v.value("camera", o.camera, "camera folder below mav0, or none");
    v.value("other_cameras", o.other_cameras, "take over the other cameras too, as CAM1, ...");
  }
  v.value("calibration", o.calibration,
          "file that goes before the recording's sensor.yaml (Kalibr, OpenCV, ROS, VINS, ...)");
  v.choice("images", o.images, {"link", "copy", "embed"},
           "how images get into the rawlog: as links or copies beside it, or inside");
  v.value("read_gt", o.read_gt, "take over the ground truth (evaluation only)");
  v.value("read_ranges", o.read_ranges, "take over the ranges of mav0/uwb0");
  v.choice("acc_unit", o.acc_unit, accelerationUnits(), "unit of the accelerometer");
  v.choice("gyro_unit", o.gyro_unit, rateUnits(), "unit of the gyro");
  v.choice("range_unit", o.range_unit, {"auto", "m", "cm", "mm", "ft", "in", "yd"},
           "unit of the ranges");
  v.value("imu_time_offset_s", o.imu_time_offset_s, {-4e9, 4e9},
          "stamp of the IMU + this = time on the cameras' clock, to 0.1 s: where one counts from "
          "power-up; what is left is found while running");
  v.value("range_factor", o.range_factor, {0.1, 10},
          "the ranges read are multiplied by this; `vir-slam check` finds it");
  v.value("range_time_offset_s", o.range_time_offset_s, {-4e9, 4e9},
          "of the ranges read: stamp + this = time on the IMU's clock; `vir-slam check` finds it");
  v.value("width_px", o.width_px, {0, 20000},
          "images are made this wide, calibration included; 0 = as they are");
  v.value("antenna", o.antenna,
          "take only the ranges of this antenna; empty: of all, each under a label of its own");
  v.value("start_s", o.start_s, {0, kInf}, "skip this much after the first image");
  v.value("max_duration_s", o.max_duration_s, {0, kInf}, "stop after this much; 0 = to the end");
  v.value("simulate_ranges", o.simulate_ranges, "draw ranges from the ground truth");
  v.value("anchor_m", o.anchor_m, 0, "x y z of each anchor in the ground truth's world");
  v.value("anchor_id", o.anchor_id, 0, "id of each anchor; empty = 0 1 2 ...");
  v.value("range_sigma_m", o.range_sigma_m, {0, 100}, "standard deviation of a drawn range");
  v.value("range_rate_hz", o.range_rate_hz, {0.001, 1000}, "drawn ranges per second and anchor");
  v.value("lever_arm_m", o.lever_arm_m, 0,
          "antenna in the body frame, of drawn ranges and of files that do not say; with three "
          "numbers for each label, UWB0 UWB1 ..., these go before sensor.yaml");
  v.value("range_seed", o.range_seed, {0, std::numeric_limits<int>::max()},
          "seed of the drawn ranges");
  v.value("nlos_share", o.nlos_share, {0, 1}, "share of drawn ranges without line of sight");
  v.value("nlos_min_m", o.nlos_min_m, {0, 1000}, "least that such a range is too long");
  v.value("nlos_max_m", o.nlos_max_m, {0, 1000}, "most that such a range is too long");
}

void validate(const EurocOptions& o) {
  const auto require = [&o](bool ok, const std::string& text) {
    if (!ok) throw InputError("[" + o.section + "] " + text);
  };
  require(!o.source.empty(), o.section == "csv"
                                 ? "source is empty: give the folder or the video"
                                 : "source is empty: give the folder that contains mav0");
  require(!o.camera.empty() && o.camera.find('/') == std::string::npos,
          "camera = " + o.camera + ": give the name of a folder below mav0, or none");
  require(o.anchor_m.size() % 3 == 0, "anchor_m has " + std::to_string(o.anchor_m.size()) +
                                          " numbers; three per anchor are needed");
  checkLeverArms(o.lever_arm_m);
  TimeNs start = 0;
  require(o.video_start == "auto" ||
              (tables::parseStamp(o.video_start, tables::StampUnit::seconds, &start) && start >= 0),
          "video_start = " + o.video_start + ": give seconds, not negative, or auto");
  if (!o.simulate_ranges) return;
  require(!o.anchor_m.empty(), "simulate_ranges = true needs anchor_m = x y z");
  const std::size_t anchors = o.anchor_m.size() / 3;
  require(o.anchor_id.empty() || o.anchor_id.size() == anchors,
          "anchor_id has " + std::to_string(o.anchor_id.size()) + " entries for " +
              std::to_string(anchors) + " anchors");
  std::set<double> ids;
  for (const double id : o.anchor_id) {
    require(id == std::floor(id) && std::abs(id) <= std::numeric_limits<int>::max(),
            "anchor_id: ids are whole numbers");
    require(ids.insert(id).second, "anchor_id: every id may occur once");
  }
  require(o.nlos_max_m >= o.nlos_min_m, "nlos_max_m is less than nlos_min_m");
}

}  // namespace vir::euroc
