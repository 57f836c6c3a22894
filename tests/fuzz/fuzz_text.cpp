/// Any bytes, or damage to a good file, as a table, a trajectory or a calibration. One program per
/// kind (VIR_FUZZ_KIND: table, trajectory, calibration):
///   VIR_FUZZ_BYTES=10000000 fuzz_table -max_len=256
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "fuzz_damage.h"
#include "fuzz_folder.h"
#include "fuzz_memory.h"
#include "vir/evaluation/trajectory.h"
#include "vir/formats/calibration_file.h"
#include "vir/tables/anchor_names.h"
#include "vir/tables/layout.h"
#include "vir/tables/ranges.h"

namespace {

const std::string kind = VIR_FUZZ_KIND;

const vir::fuzz::Folder& folder() {
  static const vir::fuzz::Folder f;
  return f;
}

/// Of every kind of calibration one.
std::vector<std::string> calibrations() {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(VIR_FUZZ_FOLDER)) {
    paths.push_back(entry.path());
    // Files that name others are to find them beside themselves.
    std::filesystem::copy_file(entry.path(), folder().path() / entry.path().filename());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<std::string> texts;
  for (const auto& path : paths) texts.push_back(vir::fuzz::Folder::readFile(path.string()));
  return texts;
}

std::string goodTable() {
  std::string text = kind == "table"
                         ? ",timestamp [ns],anchor_id,range (mm),ax,ay,az,gx_dps,gy,gz\n"
                         : "#timestamp,x,y,z,qw,qx,qy,qz\n";
  for (int i = 0; i < 30; ++i) {
    text += kind == "table" ? std::to_string(i) + "," : "";
    text += "14036365797" + std::to_string(10 + i) + "000000,0x8" + std::to_string(i) +
            ",1.5e3,0.1,0.2,9.81,1,2,3\n";
  }
  return text;
}

void readTable(const std::string& text) {
  using namespace vir::tables;
  const Layout layout = layoutOfText(text);
  const RangeColumns range = rangeColumns(layout);
  const ImuColumns imu = imuColumns(layout);
  const PoseColumns pose = poseColumns(layout);
  const ImageColumns image = imageColumns(layout);
  gyroColumns(layout, true);
  accelerometerColumns(layout, true);
  if (imu.last() < 0 || pose.last() < 0 || image.stamp < 0) std::abort();
  const UnitGuess guess = stampUnit(layout, range.stamp, 0.01);
  AnchorNames names;
  for (const auto& row : layout.rows) {
    for (const std::string& field : row) {
      vir::TimeNs t = 0;
      parseStamp(field, guess.unit, &t);
      std::int32_t number = 0;
      names.numberOf(field, &number);
    }
  }
}

void readPath(const std::string& text) {
  std::istringstream in(text);
  vir::evaluation::ReadReport report;
  const vir::Trajectory t = vir::evaluation::readTrajectory(in, &report);
  for (const auto& pose : t) {
    if (!pose.T_W_B.p.allFinite()) std::abort();
  }
}

void readCalibration(const std::string& text) {
  folder().write("fuzzed.yaml", text);
  try {
    const std::string path = (folder().path() / "fuzzed.yaml").string();
    for (const auto& c : vir::formats::readCalibrationFile(path).cameras) {
      if (!std::isfinite(c.camera.fx)) std::abort();
    }
  } catch (const vir::formats::CalibrationError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<std::string> goods =
      kind == "calibration" ? calibrations() : std::vector<std::string>{goodTable()};
  if (goods.empty() || goods[0].empty()) std::abort();
  if (size < 2) return 0;
  const std::string& good = goods[data[0] % goods.size()];
  // Keys that come twice are an error of their own: not the file twice over.
  const std::string bytes =
      vir::fuzz::input(data + 1, size - 1, good, kind == "calibration" ? 1 : 2);
  {
    // A field of one letter is a string in a list, a key of YAML a node with its place.
    const vir::fuzz::MemoryWatch watch(bytes.size(), kind == "calibration" ? 400 : 40, 1 << 20);
    if (kind == "table") readTable(bytes);
    if (kind == "trajectory") readPath(bytes);
    if (kind == "calibration") readCalibration(bytes);
  }
  vir::fuzz::count(bytes.size());
  return 0;
}
