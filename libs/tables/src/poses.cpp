/// Columns of poses, and how their attitudes are written.
#include <algorithm>
#include <cmath>

#include "axes.h"
#include "units.h"
#include "vir/core/angles.h"
#include "vir/core/parse_number.h"
#include "vir/tables/layout.h"

namespace vir::tables {
namespace {

/// Above this no angle is in radians.
constexpr double kLargestRad = 6.3;

const std::vector<std::string>& positionNames() {
  static const std::vector<std::string> names{"",
                                              "p",
                                              "p_",
                                              "t",
                                              "pos_",
                                              "position_",
                                              "p_rs_r_",
                                              "pose_position_",
                                              "pose_pose_position_",
                                              "translation_",
                                              "transform_translation_",
                                              "pos",
                                              "position"};
  return names;
}

const std::vector<std::string>& quaternionNames() {
  static const std::vector<std::string> names{"q",
                                              "q_",
                                              "q_rs_",
                                              "quat_",
                                              "orientation_",
                                              "pose_orientation_",
                                              "pose_pose_orientation_",
                                              "rotation_",
                                              "transform_rotation_",
                                              "quaternion_",
                                              "quat",
                                              "rot_",
                                              "att_",
                                              "attitude_",
                                              "att_q",
                                              "att_q_",
                                              "rot",
                                              "r_",
                                              "orientation_q",
                                              "ori_"};
  return names;
}

/// Heads of angles that are called after themselves.
const std::vector<std::string>& angleNames() {
  static const std::vector<std::string> names{
      "",     "euler_", "rpy_",         "ypr_",      "attitude_", "att_", "orientation_",
      "rot_", "angle_", "orientation_", "rotation_", "pose_",     "imu_"};
  return names;
}

/// All rows at hand.
template <typename Visit>
void eachRow(const Layout& layout, Visit visit) {
  for (const auto& row : layout.rows) visit(row);
  for (const auto& row : layout.later) visit(row);
}

/// False: not a number there.
bool valueAt(const std::vector<std::string>& row, int column, double* v) {
  const auto c = static_cast<std::size_t>(column);
  return c < row.size() && parseFinite(row[c], v);
}

/// A device writes 0 0 0 0 where it knows no attitude.
bool allQuaternionsZero(const Layout& layout, const int q[4]) {
  bool zero = !layout.rows.empty();
  eachRow(layout, [&](const std::vector<std::string>& row) {
    for (int i = 0; i < 4; ++i) {
      double v = 0;
      if (valueAt(row, q[i], &v) && v != 0) zero = false;
    }
  });
  return zero;
}

double largest(const Layout& layout, const int columns[3]) {
  double most = 0;
  eachRow(layout, [&](const std::vector<std::string>& row) {
    for (int i = 0; i < 3; ++i) {
      double v = 0;
      if (valueAt(row, columns[i], &v)) most = std::max(most, std::abs(v));
    }
  });
  return most;
}

/// `t,x,y,z,r,p,y`: the y behind the position is the yaw.
bool findLetters(const Layout& layout, const PoseColumns& pose, int* out) {
  const int r = layout.find({"r"}), p = layout.find({"p"});
  if (r < 0 || p < 0) return false;
  for (std::size_t i = 0; i < layout.names.size(); ++i) {
    const int column = static_cast<int>(i);
    if (layout.names[i] != "y" || column == pose.p[1]) continue;
    out[0] = r, out[1] = p, out[2] = column;
    return true;
  }
  return false;
}

bool findAngles(const Layout& layout, const PoseColumns& pose, int* out) {
  return findAxes(layout, angleNames(), {"roll", "pitch", "yaw"}, out) ||
         findAxes(layout, angleNames(), {"phi", "theta", "psi"}, out) ||
         findLetters(layout, pose, out);
}

void takeAngles(const Layout& layout, PoseColumns* out) {
  const Unit unit = unitAt(layout, out->angles[0]);
  const double most = largest(layout, out->angles);
  const bool named = unit.quantity == Quantity::angle;
  const bool degrees = named ? unit.factor < 1 : most > kLargestRad;
  if (named && unit.factor == 1 && most > 2 * kLargestRad) {
    std::fill(out->angles, out->angles + 3, -1);
    out->remark = "its header says that the angles are in radians, but they are up to " +
                  std::to_string(most) + ": they are not used";
    return;
  }
  out->angle_unit = named ? unit.factor : degrees ? kRadPerDeg : 1.0;
  out->remark = std::string("the attitudes are roll, pitch and yaw in ") +
                (degrees ? "degrees" : "radians") + (named ? "" : " by the size of the numbers") +
                ", taken as Rz(yaw) Ry(pitch) Rx(roll)";
}

/// Columns that look like an attitude, by name.
std::string unknownAttitude(const Layout& layout, const PoseColumns& pose) {
  static const std::vector<std::string> whole{"heading", "course", "azimuth", "bearing", "yaw",
                                              "roll",    "pitch",  "phi",     "theta",   "psi",
                                              "rx",      "ry",     "rz",      "w"};
  std::string out;
  for (std::size_t i = 0; i < layout.names.size(); ++i) {
    const std::string& name = layout.bare[i];
    const int column = static_cast<int>(i);
    if (column == pose.stamp || std::count(pose.p, pose.p + 3, column) > 0) continue;
    if (unitAt(layout, column).quantity == Quantity::rate) continue;
    bool known = std::count(whole.begin(), whole.end(), name) > 0;
    for (const char* part : {"quat", "rot", "orient", "attitude", "euler", "heading", "roll",
                             "pitch", "yaw", "angle"}) {
      known = known || name.find(part) != name.npos;
    }
    // qx, q_0, r11, r_3_3
    const bool letter = !name.empty() && (name[0] == 'q' || name[0] == 'r') && name.size() <= 5 &&
                        name.find_first_not_of("xyzw_0123456789", 1) == name.npos &&
                        name.size() > 1;
    if (name.find("cov") != name.npos || name.find("rate") != name.npos) continue;
    if (known || letter) out += (out.empty() ? "" : ", ") + layout.names[i];
  }
  return out.substr(0, 120);
}

void findAttitude(const Layout& layout, PoseColumns* out) {
  const bool quaternion =
      findAxes(layout, quaternionNames(), {"x", "y", "z", "w"}, out->q) ||
      findAxes(layout, {"q", "q_", "quat_", "quaternion_", "quat", "att_q_", "orientation_"},
               {"1", "2", "3", "0"}, out->q) ||
      findAxes(layout, {""}, {"i", "j", "k", "w"}, out->q);
  if (quaternion) return;
  if (findAngles(layout, *out, out->angles)) {
    takeAngles(layout, out);
    return;
  }
  const std::string unknown = unknownAttitude(layout, *out);
  if (unknown.empty()) return;
  out->remark = "its columns " + unknown +
                " may be an attitude, but which cannot be told, and they are not used: call them "
                "qx, qy, qz, qw or roll_deg, pitch_deg, yaw_deg";
}

/// Easting, northing and height, or north, east, down: as east, north, up or down.
bool findEastNorth(const Layout& layout, PoseColumns* out) {
  const auto find = [&](const std::vector<std::string>& wanted) {
    for (const std::string head :
         {"", "utm_", "pos_", "p_", "position_", "enu_", "ned_", "local_"}) {
      for (std::size_t i = 0; i < layout.names.size(); ++i) {
        for (const std::string& w : wanted) {
          if (layout.names[i] == head + w || layout.bare[i] == head + w) {
            return static_cast<int>(i);
          }
        }
      }
    }
    return -1;
  };
  const int east = find({"easting", "east", "e"}), north = find({"northing", "north", "n"});
  const int up = find({"up", "altitude", "alt", "height", "elevation", "u", "z", "h"});
  const int down = find({"down", "d"});
  if (east < 0 || north < 0 || (up < 0 && down < 0)) return false;
  out->p[0] = east, out->p[1] = north, out->p[2] = down >= 0 ? down : up;
  out->down = down >= 0;
  return true;
}

void dropZeroQuaternions(const Layout& layout, PoseColumns* out) {
  if (out->q[3] < 0 || !allQuaternionsZero(layout, out->q)) return;
  std::fill(out->q, out->q + 4, -1);
  out->remark = "its quaternions are all 0 0 0 0, which is no attitude";
}

}  // namespace

int PoseColumns::last() const {
  return std::max(
      {stamp, p[0], p[1], p[2], q[0], q[1], q[2], q[3], angles[0], angles[1], angles[2]});
}

void quaternionOf(const double roll_pitch_yaw[3], double xyzw[4]) {
  double s[3], c[3];
  for (int i = 0; i < 3; ++i) {
    s[i] = std::sin(roll_pitch_yaw[i] / 2);
    c[i] = std::cos(roll_pitch_yaw[i] / 2);
  }
  xyzw[0] = s[0] * c[1] * c[2] - c[0] * s[1] * s[2];
  xyzw[1] = c[0] * s[1] * c[2] + s[0] * c[1] * s[2];
  xyzw[2] = c[0] * c[1] * s[2] - s[0] * s[1] * c[2];
  xyzw[3] = c[0] * c[1] * c[2] + s[0] * s[1] * s[2];
}

void eastNorthUp(const PoseColumns& columns, double p[3], double xyzw[4]) {
  if (!columns.down) return;
  p[2] = -p[2];
  if (!columns.hasAttitude()) return;
  // Half a turn about the axis between north and east, from the left.
  const double h = std::sqrt(0.5), x = xyzw[0], y = xyzw[1], z = xyzw[2], w = xyzw[3];
  xyzw[0] = h * (w + z);
  xyzw[1] = h * (w - z);
  xyzw[2] = h * (y - x);
  xyzw[3] = -h * (x + y);
}

PoseColumns poseColumns(const Layout& layout) {
  PoseColumns out;
  out.stamp = stampColumn(layout);
  if (findAxes(layout, positionNames(), {"x", "y", "z"}, out.p) || findEastNorth(layout, &out)) {
    const Quantity of = unitAt(layout, out.p[0]).quantity;
    out.named = of == Quantity::none || of == Quantity::length;
  }
  if (out.named) {
    out.unit_m = lengthUnit(layout, out.p[0]);
    findAttitude(layout, &out);
    dropZeroQuaternions(layout, &out);
    if (out.down) {
      out.remark += std::string(out.remark.empty() ? "" : "; ") +
                    "the positions are north, east, down: turned into east, north, up";
    }
    return out;
  }
  for (int i = 0; i < 3; ++i) out.p[i] = out.stamp + 1 + i;
  out.unit_m = lengthUnit(layout, out.p[0]);
  const int first = out.stamp + 4;
  if (static_cast<int>(layout.columns) < first + 4) return out;  // a position only
  // Programs that write seconds have their numbers in TUM's order, whatever they put between them.
  const UnitGuess unit = stampUnit(layout, out.stamp, 0.02);
  const bool seconds = unit.sure && unit.unit == StampUnit::seconds;
  const bool w_first = layout.separator != ' ' && !seconds;
  for (int i = 0; i < 4; ++i) out.q[(i + (w_first ? 3 : 0)) % 4] = first + i;
  dropZeroQuaternions(layout, &out);
  return out;
}

std::string assumedOrder(const Layout& layout, const PoseColumns& columns) {
  if (columns.named || columns.q[3] < 0 || layout.separator == ' ') return {};
  const bool w_first = columns.q[3] < columns.q[0];
  return std::string("no header says so, but the attitudes are taken to be ") +
         (w_first ? "qw qx qy qz, as in EuRoC's files" : "qx qy qz qw, as in TUM's files") +
         "; name the columns if they are not";
}

}  // namespace vir::tables
