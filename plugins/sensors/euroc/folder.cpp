#include "folder.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <vector>

#include "input_error.h"

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

void findGroundTruth(const fs::path& mav0, Folder* f) {
  for (const char* name : {"state_groundtruth_estimate0", "mocap0", "vicon0", "leica0"}) {
    const fs::path dir = mav0 / name;
    if (!fs::is_directory(dir)) continue;
    f->ground_truth_dir = dir.string();
    if (fs::is_regular_file(dir / "data.csv")) {
      f->ground_truth_file = (dir / "data.csv").string();
      return;
    }
    if (const fs::path tum = tumFile(dir); !tum.empty()) {
      f->ground_truth_file = tum.string();
      return;
    }
  }
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
  f.mav0 = mav0.string();
  if (camera != "none") {
    if (!fs::is_directory(mav0 / camera)) {
      throw InputError(f.mav0 + ": holds no camera folder " + camera + "; it holds " +
                       subfolders(mav0) + " (set euroc.camera, or none)");
    }
    f.camera_dir = (mav0 / camera).string();
  }
  if (!fs::is_directory(mav0 / "imu0")) {
    throw InputError(f.mav0 + ": holds no folder imu0; it holds " + subfolders(mav0));
  }
  f.imu_dir = (mav0 / "imu0").string();
  if (fs::is_regular_file(mav0 / "uwb0" / "data.csv")) f.uwb_dir = (mav0 / "uwb0").string();
  findGroundTruth(mav0, &f);
  return f;
}

}  // namespace vir::euroc
