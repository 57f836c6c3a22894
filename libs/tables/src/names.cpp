/// What columns are called, and where they are when nothing is said.
#include <algorithm>
#include <cmath>

#include "vir/core/angles.h"
#include "vir/core/order_statistics.h"
#include "vir/core/parse_number.h"
#include "vir/core/text.h"
#include "vir/tables/layout.h"

namespace vir::tables {
namespace {

/// A name without what exports put in front and units behind: `field_angular_velocity_x`,
/// `imu_ax`, `gyro_x_rad_s`, `acc_x_g`.
std::string bare(std::string name) {
  for (const char* front : {"field_", "imu0_", "imu_", "msg_", "data_", "sensor_"}) {
    const std::string f(front);
    if (name.size() > f.size() + 1 && name.compare(0, f.size(), f) == 0) name.erase(0, f.size());
  }
  for (const char* back : {"_rad_s", "_radps", "_rads", "_rps", "_deg_s", "_degps", "_dps", "_m_s2",
                           "_mps2", "_ms2", "_m_s_2", "_mg", "_g", "_m", "_mm", "_cm"}) {
    const std::string b(back);
    if (name.size() > b.size() + 1 && name.compare(name.size() - b.size(), b.size(), b) == 0) {
      name.resize(name.size() - b.size());
      break;
    }
  }
  return name;
}

/// Every head with each of the axes: `gyro_` gives gyro_x, gyro_y, gyro_z.
bool findAxes(const Layout& layout, const std::vector<std::string>& heads,
              const std::vector<std::string>& axes, int* out) {
  std::vector<std::string> names;
  for (const std::string& name : layout.names) names.push_back(bare(name));
  for (const std::string& head : heads) {
    std::vector<int> found;
    for (const std::string& axis : axes) {
      auto at = std::find(layout.names.begin(), layout.names.end(), head + axis);
      auto i = at - layout.names.begin();
      if (at == layout.names.end()) {
        i = std::find(names.begin(), names.end(), head + axis) - names.begin();
      }
      found.push_back(i < static_cast<std::ptrdiff_t>(names.size()) ? static_cast<int>(i) : -1);
    }
    if (std::all_of(found.begin(), found.end(), [](int i) { return i >= 0; })) {
      std::copy(found.begin(), found.end(), out);
      return true;
    }
  }
  return false;
}

/// The unit in brackets, or behind the name after an underline; in lower case, without blanks.
std::string unitText(const Layout& layout, int index) {
  const auto i = static_cast<std::size_t>(index);
  if (i >= layout.names.size()) return {};
  std::string out = lowerCase(layout.units[i]);
  out.erase(std::remove(out.begin(), out.end(), ' '), out.end());
  if (!out.empty()) return out;
  const std::string& name = layout.names[i];
  const std::string short_name = bare(name);
  const std::size_t at = name.rfind(short_name);
  if (at == std::string::npos || at + short_name.size() + 1 >= name.size()) return {};
  return name.substr(at + short_name.size() + 1);
}

double angularUnit(const Layout& layout, int column) {
  const std::string unit = unitText(layout, column);
  const bool degrees = unit.rfind("deg", 0) == 0 || unit.rfind("\xC2\xB0", 0) == 0 || unit == "dps";
  return degrees ? kRadPerDeg : 1.0;
}

/// Headers are copied, numbers are converted: g only where gravity is about 1.
double forceUnit(const Layout& layout, const int columns[3]) {
  constexpr double kGravity = 9.80665;
  const std::string unit = unitText(layout, columns[0]);
  const double size = medianNorm(layout, columns);
  if (unit == "g" && size < 5) return kGravity;
  if (unit == "mg" && size > 50) return kGravity / 1000;
  return 1.0;
}

/// [m] of what a header says that lengths are in.
double lengthUnit(const Layout& layout, int column) {
  const std::string unit = unitText(layout, column);
  if (unit == "mm") return 0.001;
  return unit == "cm" ? 0.01 : 1.0;
}

}  // namespace

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
    out.named = true;
    out.unit_m = lengthUnit(layout, out.p[0]);
    if (!findAxes(layout, attitudes, {"x", "y", "z", "w"}, out.q)) {
      findAxes(layout, {"q", "q_", "quat_", "quaternion_"}, {"1", "2", "3", "0"}, out.q);
    }
    return out;
  }
  for (int i = 0; i < 3; ++i) out.p[i] = out.stamp + 1 + i;
  const int first = out.stamp + 4;
  if (static_cast<int>(layout.columns) < first + 4) return out;  // a position only
  // Programs that write seconds have their numbers in TUM's order, whatever they put between them.
  const UnitGuess unit = stampUnit(layout, out.stamp, 0.02);
  const bool seconds = unit.sure && unit.unit == StampUnit::seconds;
  const bool w_first = layout.separator != ' ' && !seconds;
  for (int i = 0; i < 4; ++i) out.q[(i + (w_first ? 3 : 0)) % 4] = first + i;
  return out;
}

std::string assumedOrder(const Layout& layout, const PoseColumns& columns) {
  if (columns.named || !columns.hasAttitude() || layout.separator == ' ') return {};
  const bool w_first = columns.q[3] < columns.q[0];
  return std::string("no header says so, but the attitudes are taken to be ") +
         (w_first ? "qw qx qy qz, as in EuRoC's files" : "qx qy qz qw, as in TUM's files") +
         "; name the columns if they are not";
}

RangeColumns rangeColumns(const Layout& layout) {
  RangeColumns out;
  out.stamp = stampColumn(layout);
  const int anchor = layout.find({"anchor_id",    "anchor",    "id",      "anchorid", "anchor_name",
                                  "responder_id", "responder", "to_id",   "node_id",  "tag_id",
                                  "dest_id",      "source_id", "dest",    "node",     "beacon_id",
                                  "beacon",       "device",    "address", "addr",     "anc_id"});
  const int range = layout.find({"range",
                                 "distance",
                                 "dist",
                                 "range_m",
                                 "distance_m",
                                 "r",
                                 "d",
                                 "dist_m",
                                 "range_mm",
                                 "dist_mm",
                                 "distance_mm",
                                 "range_cm",
                                 "distance_cm",
                                 "measurement",
                                 "tof_m",
                                 "meas",
                                 "value",
                                 "range_meas",
                                 "distance_est",
                                 "range_raw",
                                 "dist_cm",
                                 "measured_range",
                                 "measured_range_m",
                                 "measured_distance",
                                 "measured_distance_m"});
  out.named = anchor >= 0 && range >= 0;
  out.anchor = out.named ? anchor : out.stamp + 1;
  out.range = out.named ? range : out.stamp + 2;
  out.antenna = layout.find({"antenna", "antenna_id", "ant", "rx_antenna"});
  if (out.antenna < 0) {  // the robot's own radios
    const int tag = layout.find({"tag", "tag_id", "tag_name", "initiator", "initiator_id"});
    if (tag != out.anchor) out.antenna = tag;
  }
  const auto i = static_cast<std::size_t>(out.range);
  if (out.named) {
    const std::string& name = layout.names[i];
    const auto ends = [&](const std::string& end) {
      return name.size() > end.size() &&
             name.compare(name.size() - end.size(), end.size(), end) == 0;
    };
    if (layout.units[i] == "mm" || ends("_mm")) out.unit_m = 0.001;
    if (layout.units[i] == "cm" || ends("_cm")) out.unit_m = 0.01;
  }
  return out;
}

namespace {

bool endsAsImage(const std::string& text) {
  const std::size_t point = text.rfind('.');
  if (point == std::string::npos) return false;
  const std::string ending = lowerCase(text.substr(point + 1));
  for (const char* known : {"png", "jpg", "jpeg", "tif", "tiff", "bmp", "pgm", "ppm", "webp"}) {
    if (ending == known) return true;
  }
  return false;
}

}  // namespace

ImageColumns imageColumns(const Layout& layout) {
  ImageColumns out;
  out.stamp = stampColumn(layout);
  const int named = layout.find({"filename", "file", "file_name", "image", "path", "name", "frame",
                                 "image_name", "image_file", "img", "filepath", "image_path"});
  out.named = named >= 0;
  out.file = out.named ? named : out.stamp + 1;
  if (out.file >= static_cast<int>(layout.columns)) out.file = -1;
  if (out.named || layout.rows.empty()) return out;
  const std::vector<std::string>& row = layout.rows.front();
  for (std::size_t c = 0; c < row.size(); ++c) {
    if (!endsAsImage(row[c])) continue;
    out.by_content = true;
    out.file = static_cast<int>(c);
    // A name in front of the stamp.
    if (out.stamp == out.file && row.size() > 1) out.stamp = c == 0 ? 1 : 0;
    break;
  }
  return out;
}

namespace {

const std::vector<std::string>& gyroNames() {
  static const std::vector<std::string> names{"w",
                                              "w_",
                                              "g",
                                              "gyro_",
                                              "gyr_",
                                              "gyro",
                                              "gyr",
                                              "w_rs_s_",
                                              "omega_",
                                              "angular_velocity_",
                                              "gyroscope_",
                                              "angvel_",
                                              "rate_",
                                              "imu_gyro_",
                                              "omega",
                                              "ang_vel_",
                                              "angular_vel_",
                                              "gyro_rad_",
                                              "gyroscope",
                                              "rotation_rate_",
                                              "rotationrate",
                                              "angularvelocity_"};
  return names;
}

const std::vector<std::string>& forceNames() {
  static const std::vector<std::string> names{"a",
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
                                              "imu_acc_",
                                              "acceleration_",
                                              "acceleration",
                                              "accelerometer",
                                              "accelerometer_m_s2_",
                                              "linear_accel_",
                                              "linearacceleration_",
                                              "linear_acc_",
                                              "specific_force_",
                                              "f",
                                              "f_"};
  return names;
}

bool findVector(const Layout& layout, const std::vector<std::string>& heads, int* out) {
  return findAxes(layout, heads, {"x", "y", "z"}, out) ||
         findAxes(layout, heads, {"0", "1", "2"}, out);
}

}  // namespace

double medianNorm(const Layout& layout, const int columns[3]) {
  std::vector<double> norms;
  for (const auto& row : layout.rows) {
    double squared = 0;
    bool whole = true;
    for (int i = 0; i < 3 && whole; ++i) {
      const auto c = static_cast<std::size_t>(columns[i]);
      double v = 0;
      whole = c < row.size() && parseFinite(row[c], &v);
      squared += v * v;
    }
    if (whole && std::isfinite(squared)) norms.push_back(std::sqrt(squared));
  }
  return medianInPlace(&norms);
}

int VectorColumns::last() const { return std::max({stamp, v[0], v[1], v[2]}); }

VectorColumns gyroColumns(const Layout& layout, bool plain) {
  VectorColumns out;
  out.stamp = stampColumn(layout);
  out.named = findVector(layout, gyroNames(), out.v) ||
              (plain && findAxes(layout, {""}, {"x", "y", "z"}, out.v));
  if (!out.named)
    for (int i = 0; i < 3; ++i) out.v[i] = out.stamp + 1 + i;
  out.unit = angularUnit(layout, out.v[0]);
  return out;
}

VectorColumns accelerometerColumns(const Layout& layout, bool plain) {
  VectorColumns out;
  out.stamp = stampColumn(layout);
  out.named = findVector(layout, forceNames(), out.v) ||
              (plain && findAxes(layout, {""}, {"x", "y", "z"}, out.v));
  if (!out.named)
    for (int i = 0; i < 3; ++i) out.v[i] = out.stamp + 1 + i;
  out.unit = forceUnit(layout, out.v);
  return out;
}

ImuColumns imuColumns(const Layout& layout) {
  ImuColumns out;
  out.stamp = stampColumn(layout);
  out.named =
      findVector(layout, gyroNames(), out.gyro) && findVector(layout, forceNames(), out.acc);
  if (!out.named) {
    for (int i = 0; i < 3; ++i) {
      out.gyro[i] = out.stamp + 1 + i;
      out.acc[i] = out.stamp + 4 + i;
    }
    // Gravity is in the accelerometer; nothing turns at 8 rad/s for half of the beginning.
    const double first = medianNorm(layout, out.gyro), second = medianNorm(layout, out.acc);
    out.turned = first > 8.5 && first < 11.5 && second < 4;
    if (out.turned) std::swap(out.gyro, out.acc);
  } else {
    out.gyro_unit = angularUnit(layout, out.gyro[0]);
    out.acc_unit = forceUnit(layout, out.acc);
  }
  return out;
}

}  // namespace vir::tables
