#include "table_folder.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "folder_look.h"
#include "image_list.h"
#include "image_survey.h"
#include "input_error.h"
#include "table_kind.h"
#include "video_frames.h"
#include "vir/core/text.h"
#include "vir/core/text_file.h"
#include "vir/formats/calibration_file.h"
#include "vir/rawlog/labels.h"
#include "vir/tables/layout.h"
#include "wishes.h"

namespace vir::euroc {
namespace fs = std::filesystem;
namespace {

class Finder {
 public:
  explicit Finder(const EurocOptions& o) : root_(folderOfSource(o.source)) {
    if (!fs::is_directory(root_)) throw InputError(o.source + ": is no folder and no video");
    if (isVideoFile(o.source)) video_ = fs::absolute(o.source).lexically_normal().string();
    found_ = lookAround(root_.string());
    const auto is_role = [](const std::string& name) { return roles().count(name) > 0; };
    for (const std::string& wish : splitWishes(o.topics, is_role)) addWish(wish);
    folder_.root = root_.string();
  }

  Folder find() {
    findImu();
    findCameras();
    findRanges();
    findTruth();
    findCalibration();
    sayUnused();
    if (folder_.imu_file.empty() && folder_.ranges.empty() && folder_.cameras.empty()) {
      std::string why;
      for (const std::string& file : found_.no_text) {
        why += "; " + shortName(file) + " " + whyNoText(file);
      }
      throw InputError(root_.string() +
                       ": holds no table of an IMU, of ranges or of images that could be told as "
                       "such; name them: --topic imu=FILE --topic camera=LIST --topic range=FILE" +
                       why);
    }
    return std::move(folder_);
  }

 private:
  static const std::set<std::string>& roles() {
    static const std::set<std::string> all{"imu",   "accel", "gyro",         "camera",
                                           "times", "range", "anchor_range", "truth"};
    return all;
  }

  void addWish(const std::string& word) {
    const std::size_t at = word.find('=');
    const std::string role = word.substr(0, at);
    if (at == std::string::npos || roles().count(role) == 0) {
      throw InputError("[csv] topics: `" + word +
                       "` is not ROLE=FILE with a role of imu, accel, gyro, camera, times, range, "
                       "anchor_range, truth");
    }
    const std::string file = word.substr(at + 1);
    if (file == "none") {
      wishes_[role];
      return;
    }
    fs::path path = fs::path(file).is_absolute() ? fs::path(file) : root_ / file;
    // As somebody names it who gives a video, not a folder.
    if (!fs::exists(path) && fs::exists(file)) path = fs::absolute(file);
    if (!fs::exists(path)) {
      throw InputError("[csv] topics: " + word + ": there is no " + path.string());
    }
    const std::string why = whyNoText(path.string());
    if (!why.empty()) throw InputError("[csv] topics: " + word + ": " + path.string() + " " + why);
    wishes_[role].push_back(path.lexically_normal().string());
  }

  bool wished(const std::string& role) const { return wishes_.count(role) > 0; }

  std::string shortName(const std::string& path) const {
    return fs::path(path).lexically_relative(root_).string();
  }

  /// What is named, else the best of a kind; others are noted.
  std::string one(const std::string& role, TableKind kind,
                  std::initializer_list<const char*> better) {
    if (wished(role)) return wishes_[role].empty() ? "" : wishes_[role].front();
    std::vector<std::string> files = found_.tables[kind];
    if (files.empty()) return {};
    const std::string stem = fs::path(video_).stem().string();
    const auto score = [&](const std::string& f) {
      if (!stem.empty() && fs::path(f).filename().string().rfind(stem, 0) == 0) return true;
      const std::string name = lowerCase(shortName(f));
      return std::any_of(better.begin(), better.end(),
                         [&](const char* w) { return name.find(w) != std::string::npos; });
    };
    std::stable_sort(files.begin(), files.end(), [&](const std::string& a, const std::string& b) {
      return score(a) && !score(b);
    });
    for (std::size_t i = 1; i < files.size(); ++i) {
      folder_.notes.push_back(shortName(files[i]) + " (" + name(kind) + ") not read, " +
                              shortName(files[0]) + " is; --topic " + role + "=" +
                              shortName(files[i]) + " takes it instead");
    }
    say(name(kind), files[0]);
    return files[0];
  }

  void say(const std::string& what, const std::string& path) {
    folder_.notes.push_back(shortName(path) + ": taken for " + what);
  }

  void findImu() {
    const bool split = wished("gyro") && wished("accel") && !wished("imu");
    if (!split) folder_.imu_file = one("imu", TableKind::imu, {"imu0"});
    if (!folder_.imu_file.empty() || (wished("imu") && wishes_["imu"].empty())) return;
    const std::string gyro = one("gyro", TableKind::gyro, {});
    const std::string acc = one("accel", TableKind::accelerometer, {"total"});
    if (gyro.empty() != acc.empty()) {
      throw InputError(root_.string() + ": there is " +
                       (gyro.empty() ? "an accelerometer (" : "a gyro (") +
                       shortName(gyro.empty() ? acc : gyro) + ") but no " +
                       (gyro.empty() ? "gyro" : "accelerometer") + "; name it: --topic " +
                       (gyro.empty() ? "gyro" : "accel") + "=FILE");
    }
    folder_.imu_file = gyro;
    folder_.accelerometer_file = acc;
  }

  /// Where the images of a list are: where the first one is found, else where as many are.
  std::string folderOf(const std::string& list) {
    const tables::Layout layout = tables::layoutOf(list);
    ProblemLog silent;
    const auto rows = openImageList(list, &silent);
    std::vector<std::string> places{fs::path(list).parent_path().string(), root_.string()};
    places.insert(places.end(), found_.image_dirs.begin(), found_.image_dirs.end());
    for (const std::string& place : places) {
      std::error_code ec;
      if (rows->peek() && fs::is_regular_file(imageFile(place, rows->peek()->file), ec)) {
        return place;
      }
    }
    if (tables::imageColumns(layout).file >= 0) return {};
    // Stamps alone belong to the images beside or below them.
    const std::string here = fs::path(list).parent_path().string();
    for (const std::string& dir : found_.image_dirs) {
      if (dir == here || fs::path(dir).parent_path() == here) return dir;
    }
    return found_.image_dirs.size() == 1 ? found_.image_dirs.front() : std::string();
  }

  /// A list or a folder as somebody named it.
  CameraFiles cameraAt(const std::string& path) {
    if (isVideoFile(path)) return videoAt(path);
    CameraFiles c;
    if (fs::is_directory(path)) {
      c.dir = path;
      const fs::path list = fs::path(path) / "data.csv";
      if (fs::is_regular_file(list)) c.list = list.string();
      return c;
    }
    c.list = path;
    c.dir = folderOf(path);
    if (c.dir.empty()) c.dir = fs::path(path).parent_path().string();
    return c;
  }

  static bool nameHoldsTime(const std::string& dir) {
    CameraFiles c;
    c.dir = dir;
    ProblemLog silent;
    try {
      return openImages(c, &silent)->peek() != nullptr;
    } catch (const InputError&) {
      return false;
    }
  }

  void findCameras() {
    std::vector<CameraFiles> cameras;
    if (wished("camera")) {
      for (const std::string& path : wishes_["camera"]) cameras.push_back(cameraAt(path));
    } else if (!video_.empty()) {
      cameras.push_back(videoAt(video_));
    } else {
      std::set<std::string> covered;
      for (const std::string& list : found_.tables[TableKind::images]) {
        CameraFiles c;
        c.list = list;
        c.dir = folderOf(list);
        if (c.dir.empty() && !found_.videos.empty()) {
          continue;  // the times of its frames
        } else if (c.dir.empty()) {
          folder_.without_images.push_back(shortName(list));
        } else {
          cameras.push_back(c);
          covered.insert(c.dir);
          covered.insert((fs::path(c.dir) / "data").string());
          covered.insert(fs::path(firstImage(c)).parent_path().string());
        }
      }
      for (const std::string& dir : found_.image_dirs) {
        if (covered.count(dir) > 0) continue;
        CameraFiles c;
        c.dir = dir;
        if (nameHoldsTime(dir)) {
          cameras.push_back(c);
        } else {
          folder_.notes.push_back(shortName(dir) +
                                  ": images whose names hold no time, and no list of their stamps; "
                                  "--topic camera=LIST names one");
        }
      }
      for (const std::string& video : found_.videos) {
        CameraFiles c;
        c.video = video;
        cameras.push_back(c);
      }
      for (std::size_t i = 1; i < cameras.size(); ++i) {
        folder_.notes.push_back(shortName(placeOf(cameras[i])) + " not read, the camera is " +
                                shortName(placeOf(cameras[0])) +
                                "; --topic camera=" + shortName(placeOf(cameras[i])) + " takes it");
      }
      if (cameras.size() > 1) cameras.resize(1);
      if (!cameras.empty() && !cameras[0].video.empty()) cameras[0] = videoAt(cameras[0].video);
      if (!cameras.empty()) say("images", placeOf(cameras[0]));
    }
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      cameras[i].name = "cam" + std::to_string(i);
      const fs::path place = cameras[i].dir;
      const fs::path yaml =
          (cameras[i].video.empty() ? place : place.parent_path()) / "sensor.yaml";
      if (fs::is_regular_file(yaml)) cameras[i].yaml = yaml.string();
    }
    folder_.cameras = std::move(cameras);
  }

  static std::string placeOf(const CameraFiles& c) {
    if (!c.video.empty()) return c.video;
    return c.list.empty() ? c.dir : c.list;
  }

  /// With the table of its frames' times: the one named, else a list of stamps alone, best one that
  /// is called as the video is.
  CameraFiles videoAt(const std::string& path) {
    CameraFiles c;
    c.video = c.dir = path;
    if (wished("times")) {
      if (!wishes_["times"].empty()) c.list = wishes_["times"].front();
      return c;
    }
    const std::string stem = fs::path(path).stem().string();
    for (const std::string& list : found_.tables[TableKind::images]) {
      const tables::Layout layout = tables::layoutOf(list);
      if (layout.columns > 1 && tables::imageColumns(layout).file >= 0) continue;
      const bool same = fs::path(list).filename().string().rfind(stem, 0) == 0;
      if (c.list.empty() || same) c.list = list;
      if (same) break;
    }
    if (!c.list.empty()) say("the times of the frames of " + shortName(path), c.list);
    return c;
  }

  static std::string firstImage(const CameraFiles& c) {
    ProblemLog silent;
    const auto rows = openImages(c, &silent);
    return rows->peek() ? imageFile(c.dir, rows->peek()->file) : std::string();
  }

  void findRanges() {
    const std::vector<std::string> files =
        wished("range") ? wishes_["range"] : found_.tables[TableKind::range];
    std::vector<std::string> between;
    if (wished("anchor_range")) between = wishes_["anchor_range"];
    for (const std::string& file : files) {
      if (!wished("range") && isBetweenAnchors(file)) {
        if (!wished("anchor_range")) between.push_back(file);
        continue;
      }
      RangeFiles r;
      r.name = "uwb" + std::to_string(folder_.ranges.size());
      r.file = file;
      const fs::path yaml = fs::path(file).parent_path() / "sensor.yaml";
      if (fs::is_regular_file(yaml)) r.yaml = yaml.string();
      if (folder_.ranges.empty() && !found_.tables[TableKind::anchors].empty()) {
        r.anchors = found_.tables[TableKind::anchors].front();
        say("positions of anchors", r.anchors);
      }
      say("ranges (" + labelOf(r.name, rawlog::kRangeLabel) + ")", file);
      folder_.ranges.push_back(r);
    }
    for (const std::string& file : between) {
      say("ranges between anchors", file);
      folder_.ranges.push_back({"anchors", file, "", "", true});
    }
  }

  /// Told by its name: its columns are those of a robot with several antennas.
  static bool isBetweenAnchors(const std::string& file) {
    const std::string name = lowerCase(fs::path(file).filename().string());
    return name.find("anchor_range") != std::string::npos ||
           name.find("anchor_to_anchor") != std::string::npos ||
           name.find("inter_anchor") != std::string::npos;
  }

  void findTruth() {
    folder_.truth_file = one("truth", TableKind::poses,
                             {"gt", "truth", "vicon", "mocap", "leica", "optitrack", "vrpn"});
  }

  /// A `sensor.yaml` may be that of another camera: where it is not beside the camera, nor in a
  /// folder around it.
  bool belongsElsewhere(const std::string& yaml) const {
    if (fs::path(yaml).filename() != "sensor.yaml") return false;
    const CameraFiles& camera = folder_.cameras.front();
    if (!camera.yaml.empty()) return true;
    const std::string place = placeOf(camera);
    return place.rfind((fs::path(yaml).parent_path() / "").string(), 0) != 0;
  }

  /// Those that hold intrinsics; one that holds the camera's pose too is better.
  void findCalibration() {
    if (folder_.cameras.empty()) return;
    std::vector<std::string> fitting, without_pose;
    for (const std::string& file : found_.yamls) {
      if (belongsElsewhere(file)) continue;
      try {
        const formats::CalibrationFile c = formats::readCalibrationFile(file);
        if (c.cameras.empty()) continue;
        (c.cameras.front().T_B_C ? fitting : without_pose).push_back(file);
      } catch (const formats::CalibrationError&) {  // another kind of file
      }
    }
    // A camera that has a calibration of its own needs none without a pose.
    if (folder_.cameras.front().yaml.empty()) {
      fitting.insert(fitting.end(), without_pose.begin(), without_pose.end());
    }
    if (fitting.empty()) return;
    folder_.calibration = fitting.front();
    for (std::size_t i = 1; i < fitting.size(); ++i) {
      folder_.notes.push_back(shortName(fitting[i]) + ": not used, " + shortName(fitting[0]) +
                              " is; --calibration FILE takes another");
    }
  }

  /// A table that is called after what an estimator needs, where no other one has it.
  void countUnread(const std::string& file) {
    const TableKind kind = kindByName(shortName(file));
    const bool missing = (kind == TableKind::range && folder_.ranges.empty()) ||
                         (kind == TableKind::imu && folder_.imu_file.empty());
    if (missing) folder_.unread.push_back(file);
  }

  void sayUnused() {
    for (const std::string& file : found_.no_text) {
      folder_.notes.push_back(shortName(file) + " " + whyNoText(file) + "; not read");
      countUnread(file);
    }
    for (const std::string& file : found_.unused) {
      const bool named = std::any_of(wishes_.begin(), wishes_.end(), [&](const auto& w) {
        return std::count(w.second.begin(), w.second.end(), file) > 0;
      });
      if (named) continue;
      const std::string why = whyNotOfKind(file, kindByName(shortName(file)));
      folder_.notes.push_back(shortName(file) +
                              ": not read, it is no table of an IMU, ranges, images or poses as "
                              "far as can be told" +
                              (why.empty() ? "" : " (" + why + ")") +
                              "; --topic ROLE=FILE takes it");
      countUnread(file);
    }
  }

  fs::path root_;
  std::string video_;  ///< the source itself; empty: that is a folder
  Found found_;
  std::map<std::string, std::vector<std::string>> wishes_;
  Folder folder_;
};

}  // namespace

std::string folderOfSource(const std::string& source) {
  const fs::path whole = fs::absolute(source).lexically_normal();
  return (isVideoFile(source) ? whole.parent_path() : whole).string();
}

Folder findTables(const EurocOptions& options) { return Finder(options).find(); }

}  // namespace vir::euroc
