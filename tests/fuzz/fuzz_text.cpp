/// Any bytes, or damage to a good file, as a table, a trajectory or a calibration. One program per
/// kind (VIR_FUZZ_KIND: table, trajectory, calibration):
///   VIR_FUZZ_BYTES=10000000 fuzz_table -max_len=256
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include "fuzz_damage.h"
#include "vir/evaluation/trajectory.h"
#include "vir/formats/calibration_file.h"
#include "vir/tables/anchor_names.h"
#include "vir/tables/layout.h"

namespace {

const std::string kind = VIR_FUZZ_KIND;

std::string goodFile() {
  if (kind == "calibration") {
    std::ifstream file(VIR_FUZZ_FILE, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
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
  static const std::string path = "/tmp/vir-fuzz-" + std::to_string(::getpid()) + ".yaml";
  std::ofstream(path, std::ios::binary) << text;
  try {
    for (const auto& c : vir::formats::readCalibrationFile(path).cameras) {
      if (!std::isfinite(c.camera.fx)) std::abort();
    }
  } catch (const vir::formats::CalibrationError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string good = goodFile();
  if (good.empty()) std::abort();
  const std::string bytes = vir::fuzz::input(data, size, good);
  if (kind == "table") readTable(bytes);
  if (kind == "trajectory") readPath(bytes);
  if (kind == "calibration") readCalibration(bytes);
  vir::fuzz::count(bytes.size());
  return 0;
}
