/// What columns are called, and where they are when nothing is said.
#include <algorithm>
#include <cmath>

#include "axes.h"
#include "units.h"
#include "vir/core/order_statistics.h"
#include "vir/core/parse_number.h"
#include "vir/core/text.h"
#include "vir/tables/layout.h"

namespace vir::tables {
int ImuColumns::last() const {
  return std::max({stamp, gyro[0], gyro[1], gyro[2], acc[0], acc[1], acc[2]});
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
                                              "gyrorotation",
                                              "rotationrate",
                                              "angularvelocity_",
                                              "alpha_"};
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
                                              "lin_acc_",
                                              "imu_acc_",
                                              "acceleration_",
                                              "acceleration",
                                              "accelerometer",
                                              "accelerometeracceleration",
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

/// Columns called x, y, z alone: where they may be taken for it and no other quantity is named, or
/// where this one is.
bool findXyz(const Layout& layout, Quantity quantity, bool plain, int* out) {
  int found[3];
  if (!findAxes(layout, {""}, {"x", "y", "z"}, found)) return false;
  const Quantity named = unitAt(layout, found[0]).quantity;
  if (named != quantity && (!plain || named != Quantity::none)) return false;
  std::copy(found, found + 3, out);
  return true;
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
  out.named =
      findVector(layout, gyroNames(), out.v) || findXyz(layout, Quantity::rate, plain, out.v);
  if (!out.named)
    for (int i = 0; i < 3; ++i) out.v[i] = out.stamp + 1 + i;
  out.unit = rateUnit(layout, out.v[0]);
  return out;
}

VectorColumns accelerometerColumns(const Layout& layout, bool plain) {
  VectorColumns out;
  out.stamp = stampColumn(layout);
  out.named =
      findVector(layout, forceNames(), out.v) || findXyz(layout, Quantity::force, plain, out.v);
  if (!out.named)
    for (int i = 0; i < 3; ++i) out.v[i] = out.stamp + 1 + i;
  out.unit = forceUnit(layout, out.v);
  return out;
}

namespace {

/// The columns of a unit of this kind, where there are three and no more.
bool threeOf(const Layout& layout, Quantity quantity, int* out) {
  std::vector<int> found;
  for (std::size_t i = 0; i < layout.names.size(); ++i) {
    const int column = static_cast<int>(i);
    if (unitAt(layout, column).quantity == quantity) found.push_back(column);
  }
  if (found.size() != 3) return false;
  std::copy(found.begin(), found.end(), out);
  return true;
}

/// Of columns whose names are not known: which is which by their units.
bool tellByUnits(const Layout& layout, ImuColumns* c) {
  int gyro[3], acc[3];
  const bool rates = threeOf(layout, Quantity::rate, gyro);
  const bool forces = threeOf(layout, Quantity::force, acc);
  if (rates && forces) {
    std::copy(gyro, gyro + 3, c->gyro);
    std::copy(acc, acc + 3, c->acc);
    return true;
  }
  // Of one of the two only: it may stand where the other is usual.
  const bool turned = (rates && std::equal(gyro, gyro + 3, c->acc)) ||
                      (forces && std::equal(acc, acc + 3, c->gyro));
  if (turned) std::swap(c->gyro, c->acc);
  return turned;
}

}  // namespace

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
    out.by_units = tellByUnits(layout, &out);
    const Quantity unit = unitAt(layout, out.gyro[0]).quantity;
    // Gravity is in the accelerometer; nothing turns at 8 rad/s for half of the beginning.
    const double first = medianNorm(layout, out.gyro), second = medianNorm(layout, out.acc);
    out.turned =
        !out.by_units && unit != Quantity::rate && first > 8.5 && first < 11.5 && second < 4;
    if (out.turned) std::swap(out.gyro, out.acc);
  }
  out.gyro_unit = rateUnit(layout, out.gyro[0]);
  out.acc_unit = forceUnit(layout, out.acc);
  return out;
}

}  // namespace vir::tables
