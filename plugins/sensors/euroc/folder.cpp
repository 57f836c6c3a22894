#include "folder.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <vector>

#include "input_error.h"
#include "vir/core/parse_number.h"
#include "vir/rawlog/labels.h"

namespace vir::euroc {
namespace fs = std::filesystem;
namespace {

std::string subfolders(const fs::path& dir) {
  std::set<std::string> names;
  std::error_code ec;
  for (fs::directory_iterator it(dir, ec), end; !ec && it != end; it.increment(ec)) {
    if (it->is_directory(ec)) names.insert(it->path().filename().string());
  }
  std::string out;
  for (const auto& n : names) out += (out.empty() ? "" : ", ") + n;
  return out.empty() ? "no folder" : out;
}

bool looksLikeMav0(const fs::path& p) {
  return fs::is_directory(p / "imu0") || fs::is_directory(p / "cam0");
}

fs::path findMav0(const fs::path& source) {
  if (!fs::exists(source)) throw InputError(source.string() + ": no such folder");
  if (!fs::is_directory(source)) {
    throw InputError(source.string() + ": is a file; give the folder that contains mav0");
  }
  if (fs::is_directory(source / "mav0")) return source / "mav0";
  if (looksLikeMav0(source)) return source;
  throw InputError(source.string() + ": holds no folder mav0 (with cam0 and imu0); it holds " +
                   subfolders(source));
}

/// The first text file that can be a trajectory, in name order.
fs::path tumFile(const fs::path& dir) {
  std::set<fs::path> found;
  std::error_code ec;
  for (fs::directory_iterator it(dir, ec), end; !ec && it != end; it.increment(ec)) {
    const auto ext = it->path().extension();
    if (it->is_regular_file(ec) && (ext == ".txt" || ext == ".tum")) found.insert(it->path());
  }
  return found.empty() ? fs::path() : *found.begin();
}

std::string ifThere(const fs::path& file) {
  std::error_code ec;
  return fs::is_regular_file(file, ec) ? file.string() : std::string();
}

void findGroundTruth(const fs::path& mav0, Folder* f) {
  for (const char* name : {"state_groundtruth_estimate0", "mocap0", "vicon0", "leica0"}) {
    const fs::path dir = mav0 / name;
    if (!fs::is_directory(dir)) continue;
    f->truth_yaml = ifThere(dir / "sensor.yaml");
    f->truth_file = ifThere(dir / "data.csv");
    if (f->truth_file.empty()) f->truth_file = tumFile(dir).string();
    if (!f->truth_file.empty()) return;
  }
}

/// Folders `<kind><number>` with a data.csv, by number; `kind` alone counts as the first.
std::vector<std::string> numbered(const fs::path& mav0, const std::string& kind) {
  std::set<std::pair<unsigned, std::string>> found;
  std::error_code ec;
  for (fs::directory_iterator it(mav0, ec), end; !ec && it != end; it.increment(ec)) {
    const std::string name = it->path().filename().string();
    const std::string number = name.substr(std::min(name.size(), kind.size()));
    unsigned n = 0;
    if (name.rfind(kind, 0) != 0 || number.size() > 4) continue;
    if (!number.empty() && !parseNumber(number, &n)) continue;
    if (!ifThere(it->path() / "data.csv").empty()) found.emplace(n, name);
  }
  std::vector<std::string> names;
  for (const auto& [number, name] : found) names.push_back(name);
  return names;
}

CameraFiles cameraIn(const fs::path& mav0, const std::string& name) {
  const fs::path dir = mav0 / name;
  return {name, dir.string(), (dir / "data.csv").string(), "", ifThere(dir / "sensor.yaml")};
}

/// Kalibr's file of all cameras, where TUM-VI has it.
std::string chainBeside(const fs::path& mav0) {
  const fs::path around = mav0.parent_path();
  for (const char* name : {"dso/camchain.yaml", "camchain.yaml", "camchain-imucam.yaml"}) {
    const std::string file = ifThere(around / name);
    if (!file.empty()) return file;
  }
  return {};
}

}  // namespace

bool isFolder(const std::string& source) {
  std::error_code ec;
  return fs::is_directory(fs::path(source) / "mav0", ec) ||
         fs::is_regular_file(fs::path(source) / "imu0" / "data.csv", ec);
}

Folder findFolder(const std::string& source, const std::string& camera) {
  // "folder/" has an empty file name, which would end in "folder//mav0".
  const fs::path mav0 = fs::absolute(findMav0(fs::path(source))).lexically_normal();
  Folder f;
  f.root = mav0.string();
  if (camera != "none") {
    if (!fs::is_directory(mav0 / camera)) {
      throw InputError(f.root + ": holds no camera folder " + camera + "; it holds " +
                       subfolders(mav0) + " (set euroc.camera, or none)");
    }
    f.cameras.push_back(cameraIn(mav0, camera));
    for (const std::string& other : numbered(mav0, "cam")) {
      if (other != camera) f.cameras.push_back(cameraIn(mav0, other));
    }
    const auto lacks = [](const CameraFiles& c) { return c.yaml.empty(); };
    if (std::any_of(f.cameras.begin(), f.cameras.end(), lacks)) {
      f.calibration = chainBeside(mav0);
    }
  }
  if (!fs::is_directory(mav0 / "imu0")) {
    throw InputError(f.root + ": holds no folder imu0; it holds " + subfolders(mav0));
  }
  f.imu_file = (mav0 / "imu0" / "data.csv").string();
  f.imu_yaml = ifThere(mav0 / "imu0" / "sensor.yaml");
  for (const std::string& name : numbered(mav0, "uwb")) {
    const fs::path dir = mav0 / name;
    f.ranges.push_back({name, (dir / "data.csv").string(), ifThere(dir / "sensor.yaml"),
                        ifThere(dir / "anchors_truth.csv")});
  }
  for (const std::string& name : numbered(mav0, "uwb")) {
    const std::string file = ifThere(mav0 / name / "anchor_ranges.csv");
    if (!file.empty()) f.ranges.push_back({name, file, "", "", true});
  }
  findGroundTruth(mav0, &f);
  return f;
}

std::string labelOf(const std::string& name, const char* first) {
  const std::size_t digits = name.find_last_not_of("0123456789") + 1;
  return digits < name.size() ? rawlog::furtherLabel(first, name.substr(digits)) : first;
}

}  // namespace vir::euroc
