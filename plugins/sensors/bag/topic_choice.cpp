#include "topic_choice.h"

#include <algorithm>
#include <map>

#include "calibration_hook.h"
#include "camera_choice.h"
#include "camera_setup.h"
#include "input_error.h"
#include "own_labels.h"
#include "vir/core/text.h"
#include "vir/rawlog/labels.h"

namespace vir::bag {
namespace {

bool contains(const std::string& text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const char* w) { return text.find(w) != std::string::npos; });
}

bool isImu(const std::string& type) { return type == "sensor_msgs/Imu"; }
bool isPose(const std::string& type) {
  return type == "geometry_msgs/PoseStamped" || type == "geometry_msgs/TransformStamped" ||
         type == "geometry_msgs/PoseWithCovarianceStamped" ||
         type == "geometry_msgs/PointStamped" || type == "nav_msgs/Odometry";
}
bool isVector(const TopicInfo& t) {
  const std::string& type = t.type;
  return t.bare_vector || isImu(type) || type == "geometry_msgs/Vector3Stamped" ||
         type == "geometry_msgs/AccelStamped" || type == "geometry_msgs/TwistStamped";
}
bool isAccelerometer(const TopicInfo& t) {
  return isVector(t) && contains(lowerCase(t.topic), {"accel", "/acc"});
}
bool isGyro(const TopicInfo& t) { return isVector(t) && contains(lowerCase(t.topic), {"gyro"}); }
bool isTruth(const TopicInfo& t) {
  return isPose(t.type) && contains(lowerCase(t.topic), {"truth", "/gt", "_gt", "vicon", "mocap",
                                                         "vrpn", "optitrack", "qualisys", "leica"});
}

/// Whether messages of a topic can play a role.
bool fits(Role role, const TopicInfo& info) {
  const std::string& type = info.type;
  switch (role) {
    case Role::camera:
      return isImage(type);
    case Role::imu:
      return isImu(type);
    case Role::accelerometer:
    case Role::gyro:
      return isVector(info);
    case Role::truth:
    case Role::odometry:
      return isPose(type);
    case Role::range:
    case Role::peer:
    case Role::told:
      break;
  }
  return true;
}

class Chooser {
 public:
  Chooser(const Survey& survey, const BagOptions& options, ProblemLog* log)
      : survey_(survey),
        options_(options),
        calibrated_(calibratedTopics(options.calibration)),
        log_(log) {}

  Choice fromWishes(const std::vector<TopicWish>& wishes) {
    for (const TopicWish& w : wishes) {
      const TopicInfo* info = survey_.find(w.topic);
      if (info == nullptr) {
        throw InputError("topic " + w.topic + " is not in the recording; it has" + all());
      }
      if (!fits(w.role, *info)) {
        throw InputError("topic " + w.topic + ": messages of type " + info->type +
                         " cannot be taken as " + name(w.role));
      }
      add(w, *info);
      if (w.role == Role::camera && isNoPicture(*info)) {
        log_->note(w.topic +
                   ": its name says that it is no picture of a camera (depth, ...): a "
                   "run finds little to follow in it");
      }
    }
    return finish();
  }

  Choice fromTypes() {
    chooseImu();
    chooseCamera();
    choosePoses();
    for (const auto& [topic, info] : survey_.topics) {
      if (addOwn(info)) continue;
      if (knownRangeFields(info.type)) add({Role::range, topic, {}}, info);
      if (!info.range_guess.empty()) {
        addGuess(info);
      } else if (info.speaks_of_ranges) {
        log_->note(topic + " (" + info.type + ") left out: it speaks of ranges, but " +
                   (info.problem.empty() ? "which of its fields are anchor and distance its names "
                                           "do not tell: --topic range=" +
                                               topic +
                                               ":ANCHOR,DISTANCE,unit=m|mm|ft says it "
                                               "(reference=FIELD for differences)"
                                         : info.problem));
      }
    }
    if (choice_.streams.empty()) {
      throw InputError(
          "no topic has messages of a type that is known; name them: --topic "
          "camera=/topic; the recording has" +
          all());
    }
    return finish();
  }

 private:
  std::string all() const {
    std::string out;
    for (const auto& [topic, info] : survey_.topics) out += " " + topic + " (" + info.type + ")";
    return out.empty() ? " no messages" : out;
  }

  void add(const TopicWish& wish, const TopicInfo& info) {
    Stream s;
    s.role = wish.role;
    s.topic = wish.topic;
    s.type = info.type;
    if (wish.role == Role::range || wish.role == Role::peer) {
      s.range = rangeFieldsOf(wish, info.type, info.frame);
    }
    s.position_only = info.type == "geometry_msgs/PointStamped";
    choice_.streams.push_back(std::move(s));
  }

  /// What our own export says of a topic. False for any other.
  bool addOwn(const TopicInfo& info) {
    const OwnLabel own = ownLabelOf(info);
    if (own.label.empty()) return false;
    const bool peer = own.label == rawlog::kPeerLabel;
    const bool told = !isOwnRange(info.type);
    add({told ? Role::told : peer ? Role::peer : Role::range, info.topic, {}}, info);
    Stream& s = choice_.streams.back();
    s.label = own.label;
    s.anchor_name = own.anchor;
    s.p_B_U = own.antenna;
    return true;
  }

  void addGuess(const TopicInfo& info) {
    std::string fields;
    for (const std::string& f : info.range_guess) fields += (fields.empty() ? "" : ",") + f;
    log_->note(info.topic + " (" + info.type + "): taken for ranges by the names of its fields, " +
               fields + "; --topic range=" + info.topic + ":ANCHOR,DISTANCE,unit=m|mm|ft says it");
    add({Role::range, info.topic, info.range_guess}, info);
  }

  void chooseCamera() {
    const auto lacks = [this](const std::vector<std::string>& topics) {
      return lacksOf(survey_, options_, imuFrame(), topics);
    };
    const CameraChoice cameras =
        chooseCameras(survey_, calibrated_.cameras, lacks, !options_.need_calibration);
    for (const TopicInfo* t : cameras.taken) add({Role::camera, t->topic, {}}, *t);
    cameras_left_out_ = cameras.left_out;
  }

  void chooseImu() {
    const TopicInfo *imu = nullptr, *acc = nullptr, *gyro = nullptr;
    for (const auto& [topic, info] : survey_.topics) {
      if (isAccelerometer(info)) {
        if (acc == nullptr) acc = &info;
      } else if (isGyro(info)) {
        if (gyro == nullptr) gyro = &info;
      } else if (isImu(info.type) && (imu == nullptr || info.count > imu->count)) {
        imu = &info;
      }
    }
    // The one that the calibration names goes before those that measure oftener.
    const TopicInfo* named = survey_.find(calibrated_.imu);
    if (named != nullptr && isImu(named->type)) imu = named;
    if (imu != nullptr) {
      add({Role::imu, imu->topic, {}}, *imu);
    } else if (acc != nullptr && gyro != nullptr) {
      add({Role::accelerometer, acc->topic, {}}, *acc);
      add({Role::gyro, gyro->topic, {}}, *gyro);
    }
  }

  void choosePoses() {
    const TopicInfo *truth = nullptr, *odometry = nullptr;
    const auto better = [](const TopicInfo& t, const TopicInfo* than) {
      if (than == nullptr) return true;
      const auto value = [](const TopicInfo& x) {
        return (isTruth(x) ? 2 : 0) + (x.type == "geometry_msgs/PointStamped" ? 0 : 1);
      };
      return value(t) > value(*than);
    };
    for (const auto& [topic, info] : survey_.topics) {
      if (!isPose(info.type) || !ownLabelOf(info).label.empty()) continue;
      if (info.type == "nav_msgs/Odometry" && !isTruth(info)) {
        if (odometry == nullptr) odometry = &info;
      } else if (better(info, truth)) {
        truth = &info;
      }
    }
    // A pose that nothing calls the truth may be a goal or an estimate.
    if (truth != nullptr && !isTruth(*truth)) truth = nullptr;
    if (truth != nullptr) add({Role::truth, truth->topic, {}}, *truth);
    if (odometry != nullptr) add({Role::odometry, odometry->topic, {}}, *odometry);
  }

  /// The first of a kind has its plain label; the others are numbered.
  void labelStreams() {
    int cameras = 0, imus = 0, ranges = 0, truths = 0, odometries = 0;
    const auto numbered = [](const std::string& label, int n) {
      return label.substr(0, label.size() - 1) + std::to_string(n);
    };
    const auto suffixed = [](const std::string& label, int n) {
      return n == 0 ? label : label + std::to_string(n);
    };
    for (Stream& s : choice_.streams) {
      if (!s.label.empty()) continue;  // our own export knows it
      switch (s.role) {
        case Role::camera:
          s.camera = static_cast<std::size_t>(cameras);
          s.label = numbered(rawlog::kCameraLabel, cameras++);
          break;
        case Role::imu:
          s.label = numbered(rawlog::kImuLabel, imus++);
          break;
        case Role::accelerometer:
        case Role::gyro:
          s.label = rawlog::kImuLabel;
          break;
        case Role::range:
          if (!s.range.reference.empty()) {  // each has its reference in its own label
            s.label = rawlog::differencesName();
            break;
          }
          while (labelled(numbered(rawlog::kRangeLabel, ranges))) ++ranges;
          s.antenna = static_cast<std::size_t>(ranges);
          s.label = numbered(rawlog::kRangeLabel, ranges++);
          break;
        case Role::peer:
        case Role::told:
          s.label = rawlog::kPeerLabel;
          break;
        case Role::truth:
          s.label = suffixed(rawlog::kGroundTruthLabel, truths++);
          break;
        case Role::odometry:
          s.label = suffixed(rawlog::kOdometryLabel, odometries++);
          break;
      }
    }
  }

  bool labelled(const std::string& label) const {
    return std::any_of(choice_.streams.begin(), choice_.streams.end(),
                       [&](const Stream& s) { return s.label == label; });
  }

  void checkImu() const {
    int acc = 0, gyro = 0, imu = 0;
    for (const Stream& s : choice_.streams) {
      acc += s.role == Role::accelerometer;
      gyro += s.role == Role::gyro;
      imu += s.role == Role::imu;
    }
    if (acc != gyro || acc > 1 || (acc > 0 && imu > 0)) {
      throw InputError("accel and gyro go together: one topic each, and no imu topic beside them");
    }
  }

  /// Of the first IMU that was chosen.
  std::string imuFrame() const {
    for (const Stream& s : choice_.streams) {
      const bool imu = s.role == Role::imu || s.role == Role::accelerometer || s.role == Role::gyro;
      if (imu && !survey_.find(s.topic)->frame.empty()) return survey_.find(s.topic)->frame;
    }
    return {};
  }

  Choice finish() {
    checkImu();
    labelStreams();
    choice_.imu_frame = imuFrame();
    for (Stream& s : choice_.streams) {
      log_->note(s.topic + " (" + s.type + ") taken as " + name(s.role) + ", " + s.label);
      if (s.role == Role::truth || s.role == Role::odometry) placeBody(&s);
    }
    nameTheRest();
    return choice_;
  }

  /// The pose may be that of another frame of the robot.
  void placeBody(Stream* s) {
    const std::string frame = survey_.find(s->topic)->child_frame;
    const auto T = survey_.frames.between(frame, choice_.imu_frame);
    if (!T) return;
    s->T_F_B = *T;
    if (T->p.norm() < 1e-9 && T->q.angularDistance(Quat::Identity()) < 1e-9) return;
    log_->note(s->topic + ": is the pose of " + frame + "; moved to the IMU (" + choice_.imu_frame +
               ") by /tf_static");
  }

  void nameTheRest() const {
    for (const auto& [topic, info] : survey_.topics) {
      const bool taken = std::any_of(choice_.streams.begin(), choice_.streams.end(),
                                     [t = topic](const Stream& s) { return s.topic == t; });
      if (taken) continue;
      const char* role = isImage(info.type)                 ? "camera"
                         : isImu(info.type)                 ? "imu"
                         : knownRangeFields(info.type)      ? "range"
                         : info.type == "nav_msgs/Odometry" ? "odometry"
                         : isPose(info.type)                ? "truth"
                                                            : nullptr;
      if (role == nullptr) continue;
      const bool twin =
          std::any_of(choice_.streams.begin(), choice_.streams.end(),
                      [t = topic](const Stream& s) { return baseOf(s.topic) == baseOf(t); });
      const auto why = cameras_left_out_.find(topic);
      log_->note(topic + " (" + info.type + ") left out" +
                 (twin ? ": the same images in other bytes"
                  : why != cameras_left_out_.end()
                      ? ": " + why->second + "; by hand: --topic camera=" + topic +
                            " beside all else that you want"
                  : !info.problem.empty() ? ": " + info.problem
                  : isImage(info.type) && (!info.camera || isNoPicture(info))
                      ? ": no picture of a camera, by its name or encoding (depth, ...)"
                      : std::string("; to take it too, name all that you want: --topic ") + role +
                            "=" + topic));
    }
  }

  const Survey& survey_;
  const BagOptions& options_;
  const CalibratedTopics calibrated_;
  ProblemLog* log_;
  Choice choice_;
  std::map<std::string, std::string> cameras_left_out_;  // why, by topic
};

}  // namespace

Choice chooseTopics(const Survey& survey, const BagOptions& options,
                    const std::vector<TopicWish>& wishes, ProblemLog* log) {
  Chooser chooser(survey, options, log);
  return wishes.empty() ? chooser.fromTypes() : chooser.fromWishes(wishes);
}

}  // namespace vir::bag
