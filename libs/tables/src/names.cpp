/// What columns are called, and where they are when nothing is said.
#include <algorithm>
#include <charconv>

#include "vir/tables/layout.h"

namespace vir::tables {
namespace {

const std::vector<std::string>& stampNames() {
  static const std::vector<std::string> names{
      "timestamp", "stamp",        "time",    "t",       "timestamp_ns", "timestamp_us",
      "time_ns",   "timestamp_ms", "time_us", "time_ms", "timestamp_s",  "time_s",
      "t_ns",      "t_us",         "t_ms",    "t_s",     "secs",         "sec",
      "nsec",      "header_stamp", "stamp_ns"};
  return names;
}

/// Every head with each of the axes: `gyro_` gives gyro_x, gyro_y, gyro_z.
bool findAxes(const Layout& layout, const std::vector<std::string>& heads,
              const std::vector<std::string>& axes, int* out) {
  for (const std::string& head : heads) {
    std::vector<int> found;
    for (const std::string& axis : axes) found.push_back(layout.find({head + axis}));
    if (std::all_of(found.begin(), found.end(), [](int i) { return i >= 0; })) {
      std::copy(found.begin(), found.end(), out);
      return true;
    }
  }
  return false;
}

bool wholeNumber(const std::string& text, long* value) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), *value);
  return result.ec == std::errc() && result.ptr == text.data() + text.size();
}

/// 0 1 2 3 ..., or from 1 on.
bool onlyCounts(const std::vector<std::string>& column) {
  if (column.size() < 3) return false;
  long first = 0;
  if (!wholeNumber(column.front(), &first) || first < 0 || first > 1) return false;
  for (std::size_t i = 1; i < column.size(); ++i) {
    long value = 0;
    if (!wholeNumber(column[i], &value) || value != first + static_cast<long>(i)) return false;
  }
  return true;
}

std::optional<StampUnit> unitNamed(const Layout& layout, int index) {
  const auto i = static_cast<std::size_t>(index);
  if (i >= layout.names.size()) return std::nullopt;
  const std::string& name = layout.names[i];
  const auto ends = [&](const std::string& end) {
    return name.size() > end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0;
  };
  for (const StampUnit unit : {StampUnit::nanoseconds, StampUnit::microseconds,
                               StampUnit::milliseconds, StampUnit::seconds}) {
    if (layout.units[i] == tables::name(unit) || ends(std::string("_") + tables::name(unit))) {
      return unit;
    }
  }
  return std::nullopt;
}

}  // namespace

int stampColumn(const Layout& layout) {
  const int named = layout.find(stampNames());
  if (named >= 0) return named;
  const bool second = layout.columns > 1 && onlyCounts(layout.column(0)) &&
                      guessUnit(layout.column(1), 0.05).unix_time;
  return second ? 1 : 0;
}

UnitGuess stampUnit(const Layout& layout, int index, double typical_step_s) {
  return guessUnit(layout.column(static_cast<std::size_t>(std::max(index, 0))), typical_step_s,
                   unitNamed(layout, index));
}

int PoseColumns::last() const {
  return std::max({stamp, p[0], p[1], p[2], q[0], q[1], q[2], q[3]});
}

int ImuColumns::last() const {
  return std::max({stamp, gyro[0], gyro[1], gyro[2], acc[0], acc[1], acc[2]});
}

PoseColumns poseColumns(const Layout& layout) {
  PoseColumns out;
  out.stamp = stampColumn(layout);
  static const std::vector<std::string> positions{"",
                                                  "p",
                                                  "p_",
                                                  "t",
                                                  "pos_",
                                                  "position_",
                                                  "p_rs_r_",
                                                  "pose_position_",
                                                  "pose_pose_position_",
                                                  "translation_",
                                                  "field_pose_position_",
                                                  "pos",
                                                  "position"};
  static const std::vector<std::string> attitudes{"q",
                                                  "q_",
                                                  "q_rs_",
                                                  "quat_",
                                                  "orientation_",
                                                  "pose_orientation_",
                                                  "pose_pose_orientation_",
                                                  "rotation_",
                                                  "field_pose_orientation_",
                                                  "quaternion_",
                                                  "quat"};
  if (findAxes(layout, positions, {"x", "y", "z"}, out.p)) {
    findAxes(layout, attitudes, {"x", "y", "z", "w"}, out.q);
    return out;
  }
  for (int i = 0; i < 3; ++i) out.p[i] = out.stamp + 1 + i;
  const int first = out.stamp + 4;
  if (static_cast<int>(layout.columns) < first + 4) return out;  // a position only
  const bool w_first = layout.separator != ' ';
  for (int i = 0; i < 4; ++i) out.q[(i + (w_first ? 3 : 0)) % 4] = first + i;
  return out;
}

RangeColumns rangeColumns(const Layout& layout) {
  RangeColumns out;
  out.stamp = stampColumn(layout);
  const int anchor =
      layout.find({"anchor_id", "anchor", "id", "anchorid", "responder_id", "responder", "to_id",
                   "node_id", "tag_id", "dest_id", "source_id", "beacon_id"});
  const int range = layout.find({"range", "distance", "dist", "range_m", "distance_m", "r", "d"});
  const bool named = anchor >= 0 && range >= 0;
  out.anchor = named ? anchor : out.stamp + 1;
  out.range = named ? range : out.stamp + 2;
  out.antenna = layout.find({"antenna", "antenna_id", "ant", "rx_antenna"});
  return out;
}

ImageColumns imageColumns(const Layout& layout) {
  ImageColumns out;
  out.stamp = stampColumn(layout);
  const int named = layout.find({"filename", "file", "file_name", "image", "path", "name"});
  out.file = named >= 0 ? named : out.stamp + 1;
  if (out.file >= static_cast<int>(layout.columns)) out.file = -1;
  return out;
}

ImuColumns imuColumns(const Layout& layout) {
  ImuColumns out;
  out.stamp = stampColumn(layout);
  static const std::vector<std::string> rates{
      "w",          "w_",      "g",       "gyro_",    "gyr_",
      "gyro",       "gyr",     "w_rs_s_", "omega_",   "angular_velocity_",
      "gyroscope_", "angvel_", "rate_",   "imu_gyro_"};
  static const std::vector<std::string> forces{"a",
                                               "a_",
                                               "acc_",
                                               "accel_",
                                               "acc",
                                               "accel",
                                               "a_rs_s_",
                                               "linear_acceleration_",
                                               "accelerometer_",
                                               "alpha_",
                                               "lin_acc_",
                                               "imu_acc_"};
  out.named = findAxes(layout, rates, {"x", "y", "z"}, out.gyro) &&
              findAxes(layout, forces, {"x", "y", "z"}, out.acc);
  if (out.named) return out;
  for (int i = 0; i < 3; ++i) {
    out.gyro[i] = out.stamp + 1 + i;
    out.acc[i] = out.stamp + 4 + i;
  }
  return out;
}

}  // namespace vir::tables
