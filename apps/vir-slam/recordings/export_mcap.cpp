/// Export of recordings and of runs to MCAP with standard messages.
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <Eigen/Core>
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/core/mat.hpp>
#include <set>
#include <sstream>

#include "recordings/exporter.h"
#include "recordings/ros_messages.h"
#include "vir/core/parse_number.h"
#include "vir/evaluation/trajectory.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_camera.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/topic_metadata.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

using namespace mrpt::obs;

constexpr const char* kBody = "imu";
constexpr const char* kWorld = "world";

std::string topicWord(std::string text) {
  for (char& c : text) {
    const auto u = static_cast<unsigned char>(c);
    c = std::isalnum(u) != 0 ? static_cast<char>(std::tolower(u)) : '_';
  }
  return text;
}

std::string contentOf(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class McapExporter : public Exporter {
 public:
  McapExporter(const std::string& file, AnchorTexts anchors)
      : file_(file), anchors_(std::move(anchors)) {}

  Added add(CObservation& o) override {
    std::string topic = "/" + topicWord(o.sensorLabel);
    const TimeNs t = rawlog::fromMrptTime(o.timestamp);
    if (auto* image = dynamic_cast<CObservationImage*>(&o)) {
      return addImage(image, topic, t) ? Added::written : Added::unusable;
    }
    if (const auto sample = rawlog::imuSampleOf(o)) {
      out_.imu(topic, kBody, *sample);
    } else if (const auto ranges = rawlog::rangesOf(o); !ranges.empty()) {
      // The place of that anchor has the plain name.
      if (rawlog::isDeployedAnchorLabel(o.sensorLabel)) topic += "/ranges";
      describe(topic, o.sensorLabel);
      for (const Range& r : ranges) {
        const auto named = anchors_.find(r.anchor);
        out_.range(topic, kBody, r, named == anchors_.end() ? std::string() : named->second);
      }
    } else if (const auto* told = dynamic_cast<const CObservationRobotPose*>(&o);
               told != nullptr && (rawlog::isBroadcastLabel(o.sensorLabel) ||
                                   rawlog::isDeployedAnchorLabel(o.sensorLabel))) {
      return addTold(*told, topic, t) ? Added::written : Added::unusable;
    } else if (const auto pose = rawlog::poseOf(o)) {
      describe(topic, o.sensorLabel);
      if (o.sensorLabel == rawlog::kOdometryLabel) {
        out_.odometry(topic, "odom", kBody, *pose);
      } else {
        out_.pose(topic, kWorld, *pose);
      }
    } else {
      return Added::no_place;
    }
    return Added::written;
  }
  void finish() override { file_.finish(); }

 private:
  /// Which sensor a topic is, for our own import.
  void describe(const std::string& topic, const std::string& label,
                const std::string& antenna = {}) {
    if (!described_.insert(topic).second) return;
    bags::Metadata about{{rawlog::kTopicLabel, label}};
    auto anchor = rawlog::deployedAnchorOf(label);
    if (const auto source = rawlog::broadcastSourceOf(label); source) anchor = source->anchor;
    const auto named = anchor ? anchors_.find(*anchor) : anchors_.end();
    if (named != anchors_.end()) about[rawlog::kTopicAnchor] = named->second;
    if (!antenna.empty()) about[rawlog::kTopicAntenna] = antenna;
    out_.describe(topic, about);
  }

  /// What another robot told, or where an anchor was put down. False where the antenna is another
  /// than before, which has no place in the message.
  bool addTold(const CObservationRobotPose& o, const std::string& topic, TimeNs t) {
    const auto& at = o.sensorPose;
    const std::string antenna = exact(at.x()) + " " + exact(at.y()) + " " + exact(at.z());
    if (antennas_.emplace(topic, antenna).first->second != antenna) return false;
    describe(topic, o.sensorLabel, antenna);
    Mat3 covariance;
    for (int i = 0; i < 9; ++i) covariance(i / 3, i % 3) = o.pose.cov(i / 3, i % 3);
    const bool in_body = rawlog::isDeployedAnchorLabel(o.sensorLabel);
    out_.pose(topic, in_body ? kBody : "world" + topicWord(topic),
              {t, rawlog::fromMrptPose(o.pose.mean)}, covariance);
    return true;
  }

  bool addImage(CObservationImage* o, const std::string& topic, TimeNs t) {
    const std::string frame = topic.substr(1);
    if (seen_.insert(topic).second) {
      out_.transform("/tf_static", kBody, frame, {t, rawlog::fromMrptPose(o->cameraPose)});
    }
    out_.cameraInfo(topic + "/camera_info", frame, t, rawlog::fromMrptCamera(o->cameraParams));
    if (o->image.isExternallyStored()) {
      const std::string bytes = contentOf(o->image.getExternalStorageFileAbsolutePath());
      const bool png = isPng(bytes);
      const bool jpeg = bytes.rfind("\xff\xd8\xff", 0) == 0;
      if (bytes.empty()) return false;
      if (png || jpeg) {
        out_.compressedImage(topic + "/image_raw/compressed", frame, t, png ? "png" : "jpeg",
                             bytes);
        return true;
      }
    }
    try {
      o->load();
    } catch (const std::exception&) {
      return false;  // counted by the caller
    }
    cv::Mat m = o->image.asCvMat<cv::Mat>(mrpt::img::SHALLOW_COPY);
    if (!m.isContinuous()) m = m.clone();
    if (m.empty() || m.depth() != CV_8U || (m.channels() != 1 && m.channels() != 3)) return false;
    out_.image(topic + "/image_raw", frame, t, m.cols, m.rows, m.channels() == 1 ? "mono8" : "bgr8",
               m.data);
    return true;
  }

  bags::McapWriter file_;
  AnchorTexts anchors_;
  RosMessages out_{&file_};
  std::set<std::string> seen_, described_;
  std::map<std::string, std::string> antennas_;  // by topic
};

/// Fields of a line of a csv.
std::vector<double> numbersOf(const std::string& line, std::size_t most) {
  std::vector<double> out;
  std::istringstream in(line);
  for (std::string field; out.size() < most && std::getline(in, field, ',');) {
    double value = 0;
    if (!parseNumber(field, &value)) return {};
    out.push_back(value);
  }
  return out;
}

std::vector<RosMessages::Ellipsoid> anchorsOf(const std::string& file) {
  std::vector<RosMessages::Ellipsoid> out;
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line)) {
    const std::vector<double> v = numbersOf(line, 13);  // id, x, y, z, 3x3
    if (v.size() < 13) continue;
    RosMessages::Ellipsoid e;
    e.name = "anchor " + line.substr(0, line.find(','));
    e.p = Vec3(v[1], v[2], v[3]);
    for (int i = 0; i < 9; ++i) e.covariance(i / 3, i % 3) = v[static_cast<std::size_t>(4 + i)];
    if (e.p.allFinite() && e.covariance.allFinite()) out.push_back(e);
  }
  return out;
}

std::vector<Eigen::Vector3f> pointsOf(const std::string& file) {
  std::vector<Eigen::Vector3f> out;
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line) && line != "end_header") {
  }
  for (Eigen::Vector3f p; in >> p.x() >> p.y() >> p.z(); in.ignore(1 << 16, '\n')) {
    out.push_back(p);
  }
  return out;
}

}  // namespace

std::unique_ptr<Exporter> makeMcapExporter(const std::string& file, AnchorTexts anchors) {
  return std::make_unique<McapExporter>(file, std::move(anchors));
}

void exportRunToMcap(const std::string& run_folder, const std::string& file) {
  const fs::path run(run_folder);
  bags::McapWriter writer(file);
  RosMessages out(&writer);
  TimeNs last = 0;
  const auto trajectory = [&](const char* name, const char* topic, bool moving) {
    evaluation::ReadReport report;
    if (!fs::exists(run / name)) return;
    std::ifstream in(run / name, std::ios::binary);
    for (const StampedPose& p : evaluation::readTrajectory(in, &report)) {
      out.odometry(topic, kWorld, kBody, p);
      if (moving) out.transform("/tf", kWorld, kBody, p);
      last = std::max(last, p.t);
    }
  };
  trajectory("trajectory.tum", "/odometry", true);
  trajectory("trajectory_smoothed.tum", "/odometry_smoothed", false);
  out.ellipsoids("/anchors", kWorld, last, anchorsOf((run / "anchors.csv").string()));
  out.points("/landmarks", kWorld, last, pointsOf((run / "landmarks.ply").string()));
  writer.finish();
}

}  // namespace vir::app
