#include "output/run_folder.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "commands/commands.h"
#include "robots/robot_recorder.h"
#include "vir/core/parse_number.h"
#include "vir/core/text.h"
#include "vir/core/text_file.h"
#include "vir/evaluation/trajectory.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/rawlog_reader.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

/// A table with a header: cells by the name of their column.
class Table {
 public:
  explicit Table(const std::string& path) : path_(path), in_(path) {
    std::string header;
    if (!readLine(in_, &header)) throw std::runtime_error(path + " is empty or cannot be read");
    const auto names = split(header);
    for (std::size_t i = 0; i < names.size(); ++i) columns_[names[i]] = i;
  }
  bool next() {
    std::string line;
    if (!readLine(in_, &line)) return false;
    cells_ = split(line);
    ++line_;
    return true;
  }
  const std::string& text(const std::string& column) const {
    const auto at = columns_.find(column);
    if (at == columns_.end() || at->second >= cells_.size()) fail(column);
    return cells_[at->second];
  }
  double number(const std::string& column) const {
    double v = 0;
    if (!parseFinite(text(column), &v)) fail(column);
    return v;
  }
  std::uint64_t id(const std::string& column) const {
    std::uint64_t v = 0;
    if (!parseNumber(text(column), &v)) fail(column);
    return v;
  }
  int whole(const std::string& column) const {
    const double v = number(column);
    if (!(std::abs(v) <= 1e9)) fail(column);
    return static_cast<int>(v);
  }
  TimeNs stamp() const {
    TimeNs t = 0;
    if (!evaluation::parseSeconds(text("t_s"), &t)) fail("t_s");
    return t;
  }

 private:
  static std::vector<std::string> split(std::string line) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::vector<std::string> cells;
    std::size_t from = 0;
    for (std::size_t comma; (comma = line.find(',', from)) != std::string::npos; from = comma + 1) {
      cells.push_back(line.substr(from, comma - from));
    }
    cells.push_back(line.substr(from));
    return cells;
  }
  [[noreturn]] void fail(const std::string& column) const {
    throw std::runtime_error(path_ + ":" + std::to_string(line_) + ": column " + column +
                             " is missing or not as `vir-slam run` writes it");
  }

  std::string path_;
  std::ifstream in_;
  std::map<std::string, std::size_t> columns_;
  std::vector<std::string> cells_;
  int line_ = 1;
};

Trajectory readPath(const std::string& file) {
  std::ifstream in(file);
  evaluation::ReadReport report;
  Trajectory out = evaluation::readTum(in, &report);
  if (report.skipped() > 0) throw std::runtime_error(file + ": " + report.messages.front());
  return out;
}

void readPoses(const std::string& folder, team::RobotRecord* record) {
  std::map<TimeNs, int> segments;
  Table frames(folder + "/frames.csv");
  while (frames.next()) segments[frames.stamp()] = frames.whole("segment");
  for (const StampedPose& p : readPath(folder + "/trajectory.tum")) {
    const auto segment = segments.find(p.t);
    record->poses.push_back({p.t, p.T_W_B, Eigen::Matrix<double, 6, 6>::Zero(),
                             segment == segments.end() ? 0 : segment->second});
  }
  static const char* const kNames[] = {"px", "py", "pz", "rx", "ry", "rz"};
  Table table(folder + "/trajectory_covariance.csv");
  std::size_t at = 0;
  while (table.next()) {
    const TimeNs t = table.stamp();
    while (at < record->poses.size() && record->poses[at].t < t) ++at;
    if (at == record->poses.size() || record->poses[at].t != t) continue;
    for (int r = 0; r < 6; ++r) {
      for (int c = r; c < 6; ++c) {
        const double v = table.number(std::string(kNames[r]) + "_" + kNames[c]);
        record->poses[at].covariance(r, c) = record->poses[at].covariance(c, r) = v;
      }
    }
  }
}

void readAnchors(const std::string& file, team::RobotRecord* record) {
  if (!fs::exists(file) || record->poses.empty()) return;
  team::AnchorSnapshot snapshot;
  snapshot.t = record->poses.front().t;
  Table table(file);
  const auto vectorOf = [&](const char* x, const char* y, const char* z) {
    return Vec3(table.number(x), table.number(y), table.number(z));
  };
  while (table.next()) {
    Anchor a;
    a.id = table.id("id");
    parse(table.text("state"), &a.state);
    a.has_position = !table.text("x").empty();
    if (a.has_position) {
      a.p_W = vectorOf("x", "y", "z");
      static const char* const kAxes[] = {"x", "y", "z"};
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
          a.covariance(r, c) = table.number(std::string("cov_") + kAxes[r] + kAxes[c]);
        }
      }
      if (a.state == AnchorState::mirror_open) {
        a.mirror_p_W = vectorOf("mirror_x_m", "mirror_y_m", "mirror_z_m");
      }
    }
    snapshot.anchors.push_back(a);
  }
  record->anchors.push_back(snapshot);
}

/// Map points; the file's header ends with end_header.
void readLandmarks(const std::string& file, team::RobotRecord* record) {
  std::ifstream in(file);
  std::string line;
  while (readLine(in, &line) && line != "end_header") continue;
  for (std::uint64_t id = 0; readLine(in, &line); ++id) {
    const auto words = wordsOf(line);
    Landmark l;
    l.id = id;
    const bool good = words.size() >= 3 && parseFinite(words[0], &l.p_W.x()) &&
                      parseFinite(words[1], &l.p_W.y()) && parseFinite(words[2], &l.p_W.z());
    if (good) record->landmarks.push_back(l);
  }
}

}  // namespace

RunFolder openRunFolder(const std::string& path) {
  RunFolder folder{path, ""};
  for (const char* name : {"trajectory.tum", "trajectory_covariance.csv", "frames.csv"}) {
    if (fs::exists(path + "/" + name)) continue;
    throw UsageError(path + " is no results folder of `vir-slam run`: there is no " + name +
                     " in it");
  }
  std::ifstream in(path + "/summary.json");
  const auto summary = nlohmann::json::parse(in, nullptr, false);
  if (summary.is_object() && summary.contains("rawlog") && summary["rawlog"].is_string()) {
    folder.rawlog = summary["rawlog"];
  }
  return folder;
}

void readRunFolder(const RunFolder& folder, team::RobotRecord* record) {
  readPoses(folder.path, record);
  readAnchors(folder.path + "/anchors.csv", record);
  readLandmarks(folder.path + "/landmarks.ply", record);
  const std::string smoothed = folder.path + "/trajectory_smoothed.tum";
  if (!fs::exists(smoothed)) return;
  for (const StampedPose& p : readPath(smoothed)) record->keyframes.push_back({p.t, p.T_W_B});
}

void readRecording(const std::string& rawlog, const std::string& peer_label,
                   team::RobotRecord* record) {
  rawlog::RawlogReader reader(rawlog);
  while (const auto observation = reader.next()) {
    if (observation->sensorLabel != rawlog::kGroundTruthLabel) {
      noteObservation(*observation, peer_label, record);
      continue;
    }
    const auto pose = rawlog::poseOf(*observation);
    Trajectory& truth = record->truth;
    if (pose && (truth.empty() || pose->t > truth.back().t)) truth.push_back(*pose);
  }
  record->damaged = !reader.damage().empty();
}

}  // namespace vir::app
