#include "bag_recording.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "imu_units.h"
#include "input_error.h"
#include "lever_arms.h"
#include "own_labels.h"
#include "vir/core/time_bounds.h"
#include "whole_png.h"

namespace vir::bag {
namespace {

using bags::BagError;
using bags::BagMessage;
using bags::MessageView;

/// How much later than its stamp a message may come.
constexpr TimeNs kDelay = 2'000'000'000;
/// What waits at most, however stamps and times of receipt are.
constexpr std::size_t kMostHeld = 20'000, kMostHeldBytes = std::size_t{512} << 20;

int rankOf(const Reading& r) {
  if (std::holds_alternative<ImuSample>(r.what)) return 0;
  if (std::holds_alternative<Range>(r.what)) return 1;
  return std::holds_alternative<ImageReading>(r.what) ? 3 : 2;
}

/// `path` empty: in the message itself.
Vec3 vectorAt(const MessageView& m, const std::string& path) {
  const std::string at = path.empty() ? "" : path + ".";
  return {m.number(at + "x"), m.number(at + "y"), m.number(at + "z")};
}

/// Where a message of a type has the vector that a role wants.
const char* vectorPath(const MessageView& m, const std::string& type, Role role) {
  if (m.has("x") && m.has("y") && m.has("z")) return "";
  if (type == "geometry_msgs/Vector3Stamped") return "vector";
  if (type == "geometry_msgs/AccelStamped") return "accel.linear";
  if (type == "geometry_msgs/TwistStamped") return "twist.angular";
  return role == Role::accelerometer ? "linear_acceleration" : "angular_velocity";
}

std::vector<std::string> topicsOf(const std::vector<TopicWish>& wishes) {
  std::vector<std::string> out;
  for (const TopicWish& w : wishes) out.push_back(w.topic);
  return out;
}

}  // namespace

BagRecording::BagRecording(const BagOptions& options, ProblemLog* log)
    : options_(options), log_(log) {
  if (options.source.empty()) throw InputError("source is empty: give the bag's file or folder");
  if (!options.levels_16_bit.empty() &&
      (options.levels_16_bit.size() != 2 || options.levels_16_bit[1] <= options.levels_16_bit[0])) {
    throw InputError("levels_16_bit: give two numbers, black and the larger white");
  }
  checkLeverArms(options.lever_arm_m);
  const std::vector<TopicWish> wishes = parseTopics(options.topics);
  const Survey look = survey(options.source, options.first_look_s, topicsOf(wishes));
  if (look.topics.empty()) {
    throw InputError(options.source + ": holds no messages" +
                     (look.damage.empty() ? "" : "; " + look.damage.front()));
  }
  choice_ = chooseTopics(look, options, wishes, log);
  for (Stream& s : choice_.streams) {
    // Anchors of a name have the numbers that this import gives them.
    if (!s.anchor_name.empty()) {
      s.label =
          withAnchor(s.label, static_cast<std::uint64_t>(anchors_.numberOfAny(s.anchor_name)));
    }
  }
  for (const auto& [topic, info] : look.topics) looked_at_.insert(topic);
  for (const Stream& s : choice_.streams) {
    next_antenna_ += s.role == Role::range && s.range.reference.empty() ? 1 : 0;
    by_topic_[s.topic].push_back(static_cast<int>(&s - choice_.streams.data()));
    if (s.role != Role::camera) continue;
    CameraSetup camera;
    camera.topic = s.topic;
    cameras_.push_back(camera);
    const auto found = look.levels.find(s.topic);
    Levels levels = found == look.levels.end() ? Levels{} : found->second.levels();
    if (levels.known() && !options.levels_16_bit.empty()) {
      levels = {options.levels_16_bit[0], options.levels_16_bit[1]};
    }
    if (levels.known()) {
      char text[160];
      std::snprintf(text, sizeof text,
                    ": %s images stretched the same all through: %.6g is black, %.6g white "
                    "(levels_16_bit sets others)",
                    look.find(s.topic)->real_numbers ? "float" : "16-bit", levels.black,
                    levels.white);
      log->note(s.topic + text);
    }
    levels_.push_back(levels);
  }
  if (options.acc_unit != "auto") acc_unit_ = accelerationUnit(options.acc_unit);
  if (options.gyro_unit != "auto") gyro_unit_ = rateUnit(options.gyro_unit);
  checkClocks(look);
  extras_ = setUpCameras(look, options, choice_.imu_frame, &cameras_, log);
  reader_ = bags::openBag(options.source);
}

/// Stamps of one clock differ from the time of receipt by about the same.
void BagRecording::checkClocks(const Survey& look) const {
  if (options_.stamps != "header") return;
  const TopicInfo* first = nullptr;
  for (const Stream& s : choice_.streams) {
    const TopicInfo* t = look.find(s.topic);
    if (t == nullptr || !t->stamped) continue;
    if (first == nullptr) first = t;
    const double apart = toSeconds(t->lag) - toSeconds(first->lag);
    if (std::abs(apart) < 1) continue;
    char text[80];
    std::snprintf(text, sizeof text, "%.3f s", std::abs(apart));
    log_->note(t->topic + ": its stamps are " + text + " away from those of " + first->topic +
               ", as if by another clock; stamps = received takes the times of receipt instead");
  }
}

double BagRecording::progress() const {
  if (ended_ && held_.empty()) return 1;
  const double part = reader_->progress();
  if (options_.max_duration_s <= 0 || first_ == 0) return part;
  const double done = toSeconds(newest_ - first_) / (options_.start_s + options_.max_duration_s);
  return std::clamp(std::max(part, done), 0.0, 1.0);
}

std::string BagRecording::whereOf(const Stream& s, TimeNs t) const {
  char text[40];
  std::snprintf(text, sizeof text, " at %.3f s", toSeconds(t - first_));
  return s.topic + text;
}

bool BagRecording::mayGo() const {
  if (held_.empty()) return false;
  if (ended_ || held_.size() > kMostHeld || held_bytes_ > kMostHeldBytes) return true;
  return newest_ - held_.begin()->second.received > kDelay;
}

bool BagRecording::next(Reading* reading) {
  while (!mayGo()) {
    if (ended_) return false;
    if (!readOne()) {
      ended_ = true;
      tellDamage();
    }
  }
  const auto first = held_.begin();
  Held held = std::move(first->second);
  held_.erase(first);
  held_bytes_ -= held.bytes;
  if (held.reading.t < last_out_) {
    // Clocks that are apart: nothing is thrown away here, who reads it will say.
    log_->count("out_of_order_" +
                choice_.streams[static_cast<std::size_t>(held.reading.stream)].label);
  }
  last_out_ = std::max(last_out_, held.reading.t);
  *reading = std::move(held.reading);
  return true;
}

void BagRecording::tellDamage() {
  for (const std::string& n : reader_->notes()) log_->note(n);
  for (const std::string& d : reader_->damage()) log_->note(d);
  // roles::kDamageCounter: import then says that the recording ends early.
  if (!reader_->damage().empty())
    log_->count("damage", static_cast<long>(reader_->damage().size()));
  if (pairing_.dropped() > 0) {
    log_->add("imu_not_paired", "accelerometer and gyro",
              std::to_string(pairing_.dropped()) +
                  " readings of the gyro had no accelerometer around them");
  }
  for (const auto& [name, number] : anchors_.mapped()) {
    log_->note("anchor '" + tables::shownName(name) + "' has the number " + std::to_string(number) +
               " in the rawlog");
  }
}

bool BagRecording::readOne() {
  BagMessage message;
  if (!reader_->next(&message)) return false;
  if (first_ == 0) first_ = message.received;
  newest_ = std::max(newest_, message.received);
  const double since = toSeconds(message.received - first_);
  if (since < options_.start_s) return true;
  if (options_.max_duration_s > 0 && since > options_.start_s + options_.max_duration_s) {
    // Messages may come a little out of order.
    return since <= options_.start_s + options_.max_duration_s + toSeconds(kDelay);
  }
  const auto streams = by_topic_.find(message.channel->topic);
  if (streams == by_topic_.end()) {
    noteLate(*message.channel);
    return true;
  }
  for (const int index : streams->second) take(message, index);
  return true;
}

/// What is not there in the beginning is not chosen from, which must not go unsaid.
void BagRecording::noteLate(const bags::Channel& channel) {
  if (!looked_at_.insert(channel.topic).second) return;
  log_->note(channel.topic + " (" + channel.type + ") left out: it begins after the first " +
             std::to_string(std::lround(options_.first_look_s)) +
             " s, which are looked at; first_look_s = 0 looks at all");
}

void BagRecording::take(const BagMessage& message, int index) {
  const Stream& s = choice_.streams[static_cast<std::size_t>(index)];
  std::string problem;
  const bags::Definition* definition = definitions_.of(*message.channel, &problem);
  if (definition == nullptr) {
    log_->add("undecodable_" + s.label, s.topic, problem);
    return;
  }
  try {
    const MessageView m(*definition, message.data);
    const TimeNs t = stampOf(m, message, s);
    switch (s.role) {
      case Role::imu:
      case Role::accelerometer:
      case Role::gyro:
        takeImu(m, s, t, message.received, index);
        break;
      case Role::camera:
        takeImage(m, s, t, message.received, index);
        break;
      case Role::truth:
      case Role::odometry:
      case Role::told:
        takePose(m, s, t, message.received, index);
        break;
      case Role::range:
      case Role::peer:
        takeRanges(m, s, t, message.received, index);
        break;
    }
  } catch (const BagError& e) {
    log_->add("undecodable_" + s.label, whereOf(s, message.received), e.what());
  }
}

TimeNs BagRecording::stampOf(const MessageView& m, const BagMessage& message, const Stream& s) {
  if (options_.stamps == "received") return message.received;
  std::optional<TimeNs> stamp;
  if (m.has("header.stamp")) stamp = m.time("header.stamp");
  if (!stamp && m.has("stamp")) stamp = m.time("stamp");
  if (stamp && *stamp != 0) return *stamp;
  log_->count("stamp_missing_" + s.label);
  if (warned_.insert("stamp " + s.topic).second) {
    log_->note(s.topic + ": messages without a stamp get the time at which they were received");
  }
  return message.received;
}

void BagRecording::takeImu(const MessageView& m, const Stream& s, TimeNs t, TimeNs received,
                           int index) {
  const auto finite = [&](const Vec3& v) {
    if (!v.allFinite()) log_->add("imu_not_finite", whereOf(s, received), "a value is no number");
    return v.allFinite();
  };
  if (isStamp(t)) t += fromSeconds(options_.imu_time_offset_s);
  if (s.role == Role::imu) {
    const ImuSample sample{t, gyro_unit_ * vectorAt(m, "angular_velocity"),
                           acc_unit_ * vectorAt(m, "linear_acceleration")};
    if (finite(sample.gyro) && finite(sample.acc)) hold({t, index, sample}, received, 0);
    return;
  }
  const double unit = s.role == Role::accelerometer ? acc_unit_ : gyro_unit_;
  const TimedVector v{t, unit * vectorAt(m, vectorPath(m, s.type, s.role))};
  if (!finite(v.v)) return;
  if (s.role == Role::accelerometer) {
    pairing_.addAccelerometer(v);
  } else {
    pairing_.addGyro(v);
  }
  for (const ImuSample& sample : pairing_.take()) hold({sample.t, index, sample}, received, 0);
}

/// A whole PNG of the right size becomes a file as it is, and need not be decoded for that.
bool BagRecording::takeFile(const MessageView& m, const Stream& s, TimeNs t, TimeNs received,
                            int index) {
  const CameraSetup& camera = cameras_[s.camera];
  const bool same = !camera.has_intrinsics || camera.intrinsics.width == camera.recorded_width;
  if (options_.images == "embed" || !same || m.has("encoding")) return false;
  const bags::ByteView data = m.bytes("data");
  const auto size = wholePlainPng(data.data, data.size);
  if (!size) return false;
  if (camera.has_intrinsics &&
      (size->width != camera.recorded_width || size->height != camera.recorded_height)) {
    return false;  // which is then said
  }
  ImageReading image;
  image.camera = s.camera;
  image.extension = ".png";
  image.file.assign(data.data, data.data + data.size);
  hold({t, index, std::move(image)}, received, data.size);
  return true;
}

void BagRecording::takeImage(const MessageView& m, const Stream& s, TimeNs t, TimeNs received,
                             int index) {
  const CameraSetup& camera = cameras_[s.camera];
  if (takeFile(m, s, t, received, index)) return;
  const RawPicture raw = decodePicture(m);
  const int width = camera.recorded_width, height = camera.recorded_height;
  if (camera.has_intrinsics && (raw.pixels.cols != width || raw.pixels.rows != height)) {
    log_->add("image_wrong_size", whereOf(s, received),
              "has " + std::to_string(raw.pixels.cols) + "x" + std::to_string(raw.pixels.rows) +
                  " pixels, the calibration " + std::to_string(width) + "x" +
                  std::to_string(height));
    return;
  }
  Picture picture = finishPicture(raw, levels_[s.camera]);
  if (camera.has_intrinsics && camera.intrinsics.width != width) {
    cv::Mat resized;
    cv::resize(picture.pixels, resized, {camera.intrinsics.width, camera.intrinsics.height}, 0, 0,
               camera.intrinsics.width < width ? cv::INTER_AREA : cv::INTER_LINEAR);
    picture.pixels = resized;
    picture.file = {};
  }
  if (picture.stretched) log_->count("images_stretched_16_to_8_bit");
  ImageReading image;
  image.camera = s.camera;
  image.extension = picture.extension;
  if (options_.images == "embed" || picture.file.size == 0) image.pixels = picture.pixels.clone();
  if (image.pixels.empty()) {
    image.file.assign(picture.file.data, picture.file.data + picture.file.size);
  }
  const std::size_t bytes = image.file.size() + image.pixels.total() * image.pixels.elemSize();
  hold({t, index, std::move(image)}, received, bytes);
}

void BagRecording::takePose(const MessageView& m, const Stream& s, TimeNs t, TimeNs received,
                            int index) {
  const auto T = poseIn(m, s.type);
  if (!T) {
    log_->add("pose_implausible_" + s.label, whereOf(s, received),
              "a number is none, or the quaternion is not of length 1");
    return;
  }
  if (s.role == Role::told) {
    ToldPose told{{t, *T}};
    told.covariance = positionCovarianceIn(m);
    hold({t, index, told}, received, 0);
    return;
  }
  hold({t, index, StampedPose{t, *T * s.T_F_B}}, received, 0);
}

void BagRecording::hold(Reading reading, TimeNs received, std::size_t bytes) {
  held_bytes_ += bytes;
  const auto key = std::make_pair(reading.t, rankOf(reading));
  held_.emplace(key, Held{std::move(reading), received, bytes});
}

}  // namespace vir::bag
