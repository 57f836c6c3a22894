/// Export to plain tables: TUM trajectories and csv.
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <Eigen/Core>
#include <cctype>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "commands/commands.h"
#include "recordings/exporter.h"
#include "vir/core/ini_writer.h"
#include "vir/evaluation/trajectory.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

using namespace mrpt::obs;

constexpr const char* kPart = ".part";

class TumExporter : public Exporter {
 public:
  TumExporter(const std::string& folder, bool force) : files_(folder, force) {}
  Added add(CObservation& o) override {
    const auto* pose = dynamic_cast<const CObservationRobotPose*>(&o);
    if (pose == nullptr) return Added::no_place;
    files_.at(fileName(o.sensorLabel) + ".tum", "")
        .line(evaluation::tumLine(
            {rawlog::fromMrptTime(o.timestamp), rawlog::fromMrptPose(pose->pose.mean)}));
    return Added::written;
  }
  void finish() override { files_.close(); }

 private:
  FileSet files_;
};

class CsvExporter : public Exporter {
 public:
  CsvExporter(const std::string& folder, bool force, AnchorTexts anchors)
      : files_(folder, force), anchors_(std::move(anchors)) {}
  Added add(CObservation& o) override {
    const std::string t = std::to_string(rawlog::fromMrptTime(o.timestamp));
    if (const auto* imu = dynamic_cast<const CObservationIMU*>(&o)) {
      std::string line = t;
      for (const auto index : {IMU_WX, IMU_WY, IMU_WZ, IMU_X_ACC, IMU_Y_ACC, IMU_Z_ACC}) {
        line += ",";
        if (imu->has(index)) line += exact(imu->get(index));
      }
      file(o, "t_ns,wx_rad_s,wy_rad_s,wz_rad_s,ax_m_s2,ay_m_s2,az_m_s2").line(line);
    } else if (const auto* ranges = dynamic_cast<const CObservationBeaconRanges*>(&o)) {
      addRanges(*ranges, t);
    } else if (const auto* pose = dynamic_cast<const CObservationRobotPose*>(&o)) {
      const Pose T = rawlog::fromMrptPose(pose->pose.mean);
      std::string line = t;
      for (const double v : {T.p.x(), T.p.y(), T.p.z(), T.q.w(), T.q.x(), T.q.y(), T.q.z()}) {
        line += "," + exact(v);
      }
      file(o, "t_ns,x_m,y_m,z_m,qw,qx,qy,qz").line(line);
    } else if (auto* image = dynamic_cast<CObservationImage*>(&o)) {
      const bool external = image->image.isExternallyStored();
      file(o, "t_ns,width_px,height_px,file")
          .line(t + "," + std::to_string(image->cameraParams.ncols) + "," +
                std::to_string(image->cameraParams.nrows) + "," +
                (external
                     ? cell(fs::path(image->image.getExternalStorageFile()).filename().string())
                     : ""));
    } else {
      return Added::no_place;
    }
    return Added::written;
  }
  void finish() override { files_.close(); }

 private:
  results::OutputFile& file(const CObservation& o, const std::string& header) {
    return files_.at(fileName(o.sensorLabel) + ".csv", header);
  }

  void addRanges(const CObservationBeaconRanges& ranges, const std::string& t) {
    const auto reference = rawlog::differenceReferenceOf(ranges.sensorLabel);
    const std::string of = reference ? anchorText(anchors_, *reference) + "," : std::string();
    for (const auto& m : ranges.sensedData) {
      const auto& antenna = m.sensorLocationOnRobot;
      file(ranges, std::string("t_ns,") +
                       (reference ? "reference_id,anchor_id,tdoa_m" : "beacon_id,range_m") +
                       ",std_m,antenna_x_m,antenna_y_m,antenna_z_m")
          .line(t + "," + of + anchorText(anchors_, static_cast<std::uint32_t>(m.beaconID)) + "," +
                exact(m.sensedDistance) + "," + exact(ranges.stdError) + "," + exact(antenna.x()) +
                "," + exact(antenna.y()) + "," + exact(antenna.z()));
    }
  }

  FileSet files_;
  AnchorTexts anchors_;
};

/// Our header, or without one (TUM) eight numbers; nothing at all as well.
bool beginsAsOurs(const fs::path& path, const std::string& header) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  if (!std::getline(in, line)) return true;
  if (!header.empty()) return line == header;
  std::istringstream numbers(line);
  int n = 0;
  for (double v = 0; numbers >> v;) ++n;
  return n == 8 && numbers.eof();
}

}  // namespace

results::OutputFile& FileSet::at(const std::string& name, const std::string& header) {
  auto& file = files_[name];
  if (!file) {
    const fs::path path = fs::path(folder_) / name;
    std::error_code error;
    if (!force_ && fs::exists(path, error) && !beginsAsOurs(path, header)) {
      throw UsageError(path.string() +
                       " exists already, is not what this command writes and is not "
                       "overwritten: give another folder, or --force to write over it");
    }
    fs::create_directories(path.parent_path(), error);
    file = std::make_unique<results::OutputFile>(path.string() + kPart,
                                                 results::OutputFile::Named::at_once);
    if (!header.empty()) file->line(header);
  }
  return *file;
}

FileSet::~FileSet() {
  std::error_code ignored;
  for (const auto& item : files_) fs::remove((fs::path(folder_) / item.first) += kPart, ignored);
}

void FileSet::close() {
  for (auto& item : files_) item.second->close();
  for (const auto& item : files_) {
    const fs::path path = fs::path(folder_) / item.first;
    fs::rename(fs::path(path) += kPart, path);
  }
  files_.clear();
}

std::string fileName(const std::string& label) {
  std::string name = label.empty() ? "unnamed" : label;
  for (char& c : name) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.';
    if (!plain) c = '_';
  }
  for (char& c : name) {
    if (c != '.') break;
    c = '_';
  }
  return name;
}

std::string cell(std::string name) {
  for (char& c : name) {
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = '_';
  }
  if (!name.empty() && std::strchr("=+-@", name.front()) != nullptr) name.insert(0, "./");
  if (name.find_first_of(",\";") == std::string::npos) return name;
  std::string quoted = "\"";
  for (const char c : name) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

std::string exact(double v) { return numberText(v); }

std::string exact(float v) {
  char text[32];
  const auto result = std::to_chars(text, text + sizeof text, v);
  return {text, result.ptr};
}

std::unique_ptr<Exporter> makeTumExporter(const std::string& folder, bool force) {
  return std::make_unique<TumExporter>(folder, force);
}

std::unique_ptr<Exporter> makeCsvExporter(const std::string& folder, bool force,
                                          AnchorTexts anchors) {
  return std::make_unique<CsvExporter>(folder, force, std::move(anchors));
}

}  // namespace vir::app
