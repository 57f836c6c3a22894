#include "table_kind.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "text_fields.h"
#include "vir/core/text.h"
#include "vir/tables/layout.h"
#include "vir/tables/ranges.h"

namespace vir::euroc {
namespace fs = std::filesystem;
namespace {

using tables::Layout;

bool holdsAny(const std::string& text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const char* w) { return text.find(w) != std::string::npos; });
}

/// Share of the rows in which a column is a number.
double numeric(const Layout& layout, std::size_t column) {
  if (layout.rows.empty()) return 0;
  long n = 0;
  for (const auto& row : layout.rows) {
    double v = 0;
    if (column < row.size() && parseNumber(row[column], &v)) ++n;
  }
  return static_cast<double>(n) / static_cast<double>(layout.rows.size());
}

bool allNumeric(const Layout& layout, std::size_t columns) {
  if (layout.columns < columns) return false;
  for (std::size_t c = 0; c < columns; ++c) {
    if (numeric(layout, c) < 0.9) return false;
  }
  return true;
}

/// Do four columns from `first` on hold unit quaternions that are not all one axis of the numbers?
bool unitQuaternions(const Layout& layout, std::size_t first) {
  long good = 0;
  for (const auto& row : layout.rows) {
    double squared = 0;
    bool whole = row.size() >= first + 4;
    for (std::size_t i = 0; i < 4 && whole; ++i) {
      double v = 0;
      whole = parseNumber(row[first + i], &v);
      squared += v * v;
    }
    if (whole && std::abs(squared - 1) < 0.02) ++good;
  }
  return !layout.rows.empty() && good * 10 >= static_cast<long>(layout.rows.size()) * 9;
}

bool isForce(double size) {
  return (size > 8.5 && size < 11.5) || (size > 0.9 && size < 1.1) || (size > 900 && size < 1100);
}

bool holdsForce(const Layout& layout) {
  const int first[3] = {1, 2, 3}, second[3] = {4, 5, 6};
  return isForce(tables::medianNorm(layout, first)) || isForce(tables::medianNorm(layout, second));
}

bool isPoseName(const std::string& name) {
  return holdsAny(name, {"gt", "truth", "pose", "vicon", "mocap", "leica", "traj", "optitrack",
                         "tum", "vrpn", "reference", "position"});
}

bool isRangeName(const std::string& name) {
  return holdsAny(name, {"uwb", "range", "ranging", "dist"});
}

TableKind byHeader(const Layout& layout, const std::string& name) {
  if (tables::imuColumns(layout).named) return TableKind::imu;
  const tables::PoseColumns pose = tables::poseColumns(layout);
  const bool no_time = tables::namedStampColumn(layout) < 0;
  const int id = layout.find({"id", "anchor", "anchor_id", "name", "label"});
  if (pose.named && no_time && id >= 0) return TableKind::anchors;
  if (tables::imageColumns(layout).named && tables::imageColumns(layout).file >= 0) {
    return TableKind::images;
  }
  const tables::RangeColumns range = tables::rangeColumns(layout);
  if (range.named) return TableKind::range;
  // `A0, A1, A2` may be an accelerometer.
  const bool wide = !range.wide.empty() && !pose.named;
  if (wide && isRangeName(name)) return TableKind::range;
  const bool gyro = tables::gyroColumns(layout, false).named;
  const bool acc = tables::accelerometerColumns(layout, false).named;
  if (gyro != acc) return gyro ? TableKind::gyro : TableKind::accelerometer;
  if (wide) return TableKind::range;
  if (!pose.named) {
    return tables::imuColumns(layout).by_units ? TableKind::imu : TableKind::none;
  }
  if (!pose.hasAttitude() && holdsAny(name, {"acc"})) return TableKind::accelerometer;
  if (!pose.hasAttitude() && holdsAny(name, {"gyr"})) return TableKind::gyro;
  return TableKind::poses;
}

TableKind byNumbers(const Layout& layout, const std::string& name) {
  if (layout.columns == 1 && numeric(layout, 0) > 0.9) {
    return holdsAny(name, {"time", "stamp", "cam", "image", "frame", "rgb", "img"})
               ? TableKind::images
               : TableKind::none;
  }
  if (holdsAny(name, {"acc"}) && allNumeric(layout, 4)) return TableKind::accelerometer;
  if (holdsAny(name, {"gyr"}) && allNumeric(layout, 4)) return TableKind::gyro;
  if (holdsAny(name, {"imu"}) && allNumeric(layout, 7)) return TableKind::imu;
  if (isRangeName(name) && layout.columns >= 3 && numeric(layout, 0) > 0.9 &&
      numeric(layout, 2) > 0.9) {
    return TableKind::range;
  }
  const bool poses = tables::whyNoPoses(layout).empty();
  if (poses && allNumeric(layout, 8) && (unitQuaternions(layout, 4) || isPoseName(name))) {
    return TableKind::poses;
  }
  // The numbers of an attitude may look like a force in g.
  if (!tables::namesAll(layout) && allNumeric(layout, 7) && holdsForce(layout)) {
    return TableKind::imu;
  }
  if (poses && isPoseName(name) && allNumeric(layout, 4)) return TableKind::poses;
  return TableKind::none;
}

}  // namespace

const char* name(TableKind kind) {
  switch (kind) {
    case TableKind::imu:
      return "IMU";
    case TableKind::gyro:
      return "gyro";
    case TableKind::accelerometer:
      return "accelerometer";
    case TableKind::range:
      return "ranges";
    case TableKind::images:
      return "list of images";
    case TableKind::poses:
      return "poses";
    case TableKind::anchors:
      return "anchors";
    case TableKind::none:
      break;
  }
  return "-";
}

TableKind kindByName(const std::string& relative) {
  const std::string name = lowerCase(fs::path(relative).stem().string());
  if (holdsAny(name, {"imu"})) return TableKind::imu;
  if (isRangeName(name)) return TableKind::range;
  return isPoseName(name) ? TableKind::poses : TableKind::none;
}

std::string whyNotOfKind(const std::string& path, TableKind kind) {
  if (kind == TableKind::range) return tables::whyNoRanges(tables::layoutOf(path));
  if (kind == TableKind::poses) return tables::whyNoPoses(tables::layoutOf(path));
  return {};
}

bool mayBeTable(const std::string& path) {
  const std::string ending = lowerCase(fs::path(path).extension().string());
  return ending == ".csv" || ending == ".txt" || ending == ".tum" || ending == ".tsv" ||
         ending == ".dat";
}

TableKind kindOfTable(const std::string& path, const std::string& relative) {
  const std::string name = lowerCase(relative);
  const std::string own = lowerCase(fs::path(path).stem().string());
  if (holdsAny(own, {"magnet", "baro", "gravity", "gps", "gnss", "location", "pressure", "compass",
                     "depth", "battery", "temperature", "annotation", "metadata", "readme"})) {
    return TableKind::none;
  }
  const Layout layout = tables::layoutOf(path);
  if (layout.rows.empty()) return TableKind::none;
  if (holdsAny(own, {"anchor"}) && layout.columns == 4 && tables::namedStampColumn(layout) < 0 &&
      !tables::rangeColumns(layout).named && numeric(layout, 1) > 0.9 && numeric(layout, 3) > 0.9) {
    return TableKind::anchors;
  }
  if (!layout.names.empty()) {
    const TableKind kind = byHeader(layout, own);
    if (kind != TableKind::none) return kind;
  }
  const tables::ImageColumns images = tables::imageColumns(layout);
  if (images.by_content) return TableKind::images;
  // Text that is no table has few rows that begin with a time.
  const int stamp = tables::stampColumn(layout);
  if (numeric(layout, static_cast<std::size_t>(stamp)) < 0.9) return TableKind::none;
  return byNumbers(layout, name);
}

}  // namespace vir::euroc
