#include "robots/common_places.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "setup/given_maps.h"
#include "vir/core/settings.h"
#include "vir/mission/map_tie.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/gray_image.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_error.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/rawlog_reader.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

/// An image so far from a keyframe's stamp is another one: offsets between clocks of camera and IMU
/// change by milliseconds while they become known.
constexpr TimeNs kSameImage = fromSeconds(0.012);
constexpr TimeNs kSamePose = fromSeconds(0.001);

/// The images of a recording, in order of time.
class ImagesOfRun {
 public:
  ImagesOfRun(const std::string& rawlog, double time_offset_s)
      : reader_(rawlog), offset_(fromSeconds(time_offset_s)) {}

  /// The one nearest to a stamp of the IMU's clock; stamps rise from call to call.
  std::optional<Image> at(TimeNs t) {
    while (!ended_ && (!next_ || timeOf(*next_) < t)) advance();
    const Stamped* nearest = nullptr;
    for (const Stamped* s : {last_ ? &*last_ : nullptr, next_ ? &*next_ : nullptr}) {
      if (s == nullptr || std::abs(timeOf(*s) - t) > kSameImage) continue;
      if (nearest == nullptr || std::abs(timeOf(*s) - t) < std::abs(timeOf(*nearest) - t)) {
        nearest = s;
      }
    }
    if (nearest == nullptr) return std::nullopt;
    try {
      gray_ = rawlog::grayImageOf(*nearest->observation);
    } catch (const std::exception&) {
      return std::nullopt;  // as without it: told by their number
    }
    return gray_ ? std::optional<Image>(gray_->view()) : std::nullopt;
  }

 private:
  struct Stamped {
    mrpt::obs::CObservation::Ptr observation;
    TimeNs t = 0;  ///< on the camera's clock
  };
  TimeNs timeOf(const Stamped& s) const { return s.t + offset_; }

  void advance() {
    while (const auto o = reader_.next()) {
      if (o->sensorLabel != rawlog::kCameraLabel || !rawlog::isImage(*o)) continue;
      last_ = std::move(next_);
      next_ = Stamped{o, rawlog::fromMrptTime(o->timestamp)};
      return;
    }
    ended_ = true;
  }

  rawlog::RawlogReader reader_;
  const TimeNs offset_;
  std::optional<Stamped> last_, next_;
  std::optional<rawlog::GrayImage> gray_;
  bool ended_ = false;
};

/// The run's pose at a keyframe; none where the keyframe is of an earlier run.
const team::KnownPose* poseOf(const PlaceKeyframe& k, const team::RobotRecord& record) {
  const auto at =
      std::lower_bound(record.poses.begin(), record.poses.end(), k.t - kSamePose,
                       [](const team::KnownPose& pose, TimeNs t) { return pose.t < t; });
  return at != record.poses.end() && at->t <= k.t + kSamePose ? &*at : nullptr;
}

/// Without what belongs to a world that the robot has left; `own`: only what the run itself saw.
mission::MissionMap ofTheLastWorld(mission::MissionMap map, const team::RobotRecord& record,
                                   bool own) {
  const int last = record.poses.back().segment;
  auto& all = map.keyframes;
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&](const std::shared_ptr<const PlaceKeyframe>& k) {
                             const team::KnownPose* pose = poseOf(*k, record);
                             return pose == nullptr ? own : pose->segment != last;
                           }),
            all.end());
  return map;
}

void tell(const mission::MapTie& tie, const std::string& a, const std::string& b,
          const LogSink& log) {
  if (tie.imageless > 0) {
    vir::log(log, LogLevel::warning,
             std::to_string(tie.imageless) + " keyframes in the map of robot " + b +
                 " have no image in its recording that could be compared with what " + a +
                 " has seen: not looked for");
  }
  vir::log(log, LogLevel::info,
           "images of " + a + " and " + b + ": " + std::to_string(tie.shared.places) +
               " places in common, by " + std::to_string(tie.shared.images) + " of " +
               std::to_string(tie.looked) + " keyframes; loops refused or taken back: " +
               std::to_string(tie.loops.refused + tie.loops.taken_back));
}

}  // namespace

std::string mapOfFinished(const std::string& given, const std::string& folder) {
  if (!given.empty()) {
    readMap(given);
    return given;
  }
  if (!fs::is_regular_file(folder + "/used.ini")) return {};
  const Settings used = Settings::fromFile(folder + "/used.ini");
  const Setting* saved = used.find("Loops", "save_map");
  if (saved == nullptr || saved->value.empty()) return {};
  const fs::path there = saved->value;
  // The folder may have been moved with the map in it.
  for (const fs::path& file : {fs::path(folder) / there.filename(), there}) {
    if (fs::is_regular_file(file)) return file.string();
  }
  return {};
}

void keepMap(const std::string& used, const results::ResultsFolder& own, RobotFile* robot) {
  const std::string file = own.file(kMapName);
  fs::remove(file);  // of an earlier run: not to be taken for this one's
  const Settings all = Settings::fromText(used, "used.ini");
  const Setting* loops = all.find("Estimator", "loops");
  if (loops == nullptr || loops->value != "true") return;
  if (all.find("Loops", "save_map") == nullptr) return;
  try {
    rawlog::calibrationIn(robot->rawlog, rawlog::kCameraLabel);
  } catch (const std::runtime_error&) {
    return;  // no image
  }
  robot->settings.set("Loops.save_map=" + fs::absolute(file).lexically_normal().string());
}

team::PlacesOfPairs placesInCommon(const Prepared& prepared, const results::ResultsFolder& folder,
                                   const std::vector<team::RobotRecord>& records,
                                   const LogSink& log) {
  if (!prepared.rendezvous.use_places) return {};
  std::vector<std::optional<mission::MissionMap>> maps;
  for (std::size_t i = 0; i < records.size(); ++i) {
    maps.emplace_back();
    const RobotFile& robot = prepared.robots[i];
    const std::string file =
        robot.finished.empty() ? folder.file(robot.name) + "/" + kMapName : robot.map;
    if (records[i].poses.empty() || !fs::is_regular_file(file)) continue;
    try {
      maps.back() = mission::loadMap(file);
    } catch (const std::runtime_error& e) {
      vir::log(log, LogLevel::warning,
               std::string(e.what()) + ": places of robot " + records[i].name + " are not used");
    }
  }
  team::PlacesOfPairs out;
  for (std::size_t i = 0; i < records.size(); ++i) {
    for (std::size_t j = i + 1; j < records.size(); ++j) {
      if (!maps[i] || !maps[j]) continue;
      const team::RobotRecord &a = records[i], &b = records[j];
      ImagesOfRun images(prepared.robots[j].rawlog, maps[j]->calibration.time_offset_s);
      try {
        mission::MapTie tie =
            mission::tie(ofTheLastWorld(*maps[i], a, false), ofTheLastWorld(*maps[j], b, true),
                         [&](const PlaceKeyframe& k) { return images.at(k.t); }, {});
        tell(tie, a.name, b.name, log);
        if (tie.shared.places == 0) continue;
        tie.shared.segment_A = a.poses.back().segment;
        tie.shared.segment_B = b.poses.back().segment;
        out[{a.name, b.name}] = tie.shared;
      } catch (const std::exception& e) {
        vir::log(log, LogLevel::warning,
                 "places of " + a.name + " and " + b.name +
                     " cannot be compared: " + rawlog::withoutStackTrace(e));
      }
    }
  }
  return out;
}

}  // namespace vir::app
