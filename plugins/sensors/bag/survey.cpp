#include "survey.h"

#include <algorithm>
#include <cstdio>

#include "range_fields.h"
#include "vir/core/text.h"

namespace vir::bag {
namespace {

using bags::BagMessage;
using bags::MessageView;

/// Messages of a topic that are looked into; 16-bit images are every so often for longer.
constexpr long kLooked = 5;
constexpr long kLevelImages = 40;
/// However short the recording's time is, so much is enough.
constexpr std::uint64_t kMostBytes = std::uint64_t{2} << 30;

CameraInfo cameraInfoOf(const MessageView& m) {
  // The matrices have capitals in ROS 1.
  const auto list = [&](const char* one, const char* two) {
    return m.numbers(m.has(one) ? one : two, 32);
  };
  CameraInfo c;
  c.width = static_cast<int>(std::clamp<std::int64_t>(m.integer("width"), 0, 100'000));
  c.height = static_cast<int>(std::clamp<std::int64_t>(m.integer("height"), 0, 100'000));
  c.model = m.text("distortion_model");
  c.D = list("D", "d");
  c.K = list("K", "k");
  c.P = list("P", "p");
  c.binning = static_cast<int>(std::clamp<std::int64_t>(m.integer("binning_x"), 1, 64));
  return c;
}

void lookAtImage(const MessageView& m, TopicInfo* info, Survey* out) {
  if (info->count <= kLooked) {
    const std::string why = whyNoPicture(m);
    info->camera = why.empty();
    if (!info->camera) throw bags::BagError(why);
  }
  LevelFinder& levels = out->levels[info->topic];
  const bool deep = levels.images() > 0;
  if (!info->camera || (info->count > kLooked &&
                        (!deep || levels.images() >= kLevelImages || info->count % 5 != 0))) {
    return;
  }
  const RawPicture raw = decodePicture(m);
  info->real_numbers = raw.pixels.depth() == CV_32F;
  info->width = raw.pixels.cols;
  info->height = raw.pixels.rows;
  levels.add(raw.pixels);
}

void lookInto(const MessageView& m, const BagMessage& message, TopicInfo* info, Survey* out) {
  if (info->type == "sensor_msgs/CameraInfo") {
    if (out->camera_infos.count(info->topic) == 0) {
      out->camera_infos[info->topic] = cameraInfoOf(m);
    }
  } else if (info->type == "tf2_msgs/TFMessage" || info->type == "tf/tfMessage") {
    if (info->topic.find("tf_static") != std::string::npos) out->frames.add(m);
    return;
  }
  if (!info->stamped && m.has("header.stamp")) {
    const auto stamp = m.time("header.stamp");
    if (stamp && *stamp != 0) {
      info->stamped = true;
      info->lag = message.received - *stamp;
    }
  }
  if (info->frame.empty() && m.has("header.frame_id")) info->frame = m.text("header.frame_id");
  if (info->child_frame.empty() && m.has("child_frame_id")) {
    info->child_frame = m.text("child_frame_id");
  }
  if (isImage(info->type)) lookAtImage(m, info, out);
}

/// By the names of type and topic; not one of the known types.
bool mayHoldRanges(const TopicInfo& info) {
  if (knownRangeFields(info.type)) return false;
  const std::string name = lowerCase(info.type + info.topic);
  for (const char* word :
       {"uwb", "tdoa", "ranging", "range", "distance", "pozyx", "dwm", "anchor"}) {
    if (name.find(word) != std::string::npos) return true;
  }
  return false;
}

bool hasBareVector(const bags::MessageType& type) {
  int found = 0;
  for (const bags::Field& f : type.fields) {
    const bool number = f.kind == bags::Kind::float32 || f.kind == bags::Kind::float64;
    found += number && !f.array && (f.name == "x" || f.name == "y" || f.name == "z");
  }
  return found == 3;
}

bool worthLooking(const TopicInfo& info) {
  if (info.count <= kLooked || isImage(info.type)) return true;
  return info.topic.find("tf_static") != std::string::npos;
}

}  // namespace

const bags::Definition* Definitions::of(const bags::Channel& channel, std::string* problem) {
  const auto key =
      std::make_tuple(channel.definition.get(), channel.type, static_cast<int>(channel.wire));
  auto entry = known_.find(key);
  if (entry == known_.end()) {
    Entry e;
    e.text = channel.definition;
    try {
      e.definition = bags::Definition::of(channel);
    } catch (const bags::BagError& error) {
      e.problem = error.what();
    }
    entry = known_.emplace(key, std::move(e)).first;
  }
  if (problem != nullptr) *problem = entry->second.problem;
  return entry->second.definition.get();
}

bool isImage(const std::string& type) {
  return type == "sensor_msgs/Image" || type == "sensor_msgs/CompressedImage";
}

const TopicInfo* Survey::find(const std::string& topic) const {
  const auto it = topics.find(topic);
  return it == topics.end() ? nullptr : &it->second;
}

Survey survey(const std::string& source, double seconds, const std::vector<std::string>& wanted) {
  const auto reader = bags::openBag(source);
  Survey out;
  Definitions definitions;
  BagMessage message;
  std::uint64_t bytes = 0;
  const auto enough = [&] {
    if (seconds <= 0 || out.last - out.first < fromSeconds(std::min(seconds, 1e9))) {
      if (seconds <= 0 || bytes < kMostBytes) return false;
    }
    return std::all_of(wanted.begin(), wanted.end(),
                       [&](const std::string& t) { return out.topics.count(t) > 0; });
  };
  while (!enough()) {
    if (!reader->next(&message)) {
      out.whole = true;
      break;
    }
    bytes += message.data.size;
    TopicInfo& info = out.topics[message.channel->topic];
    if (info.count == 0) {
      info.topic = message.channel->topic;
      info.type = message.channel->type;
      info.metadata = message.channel->metadata;
      info.first = message.received;
      info.speaks_of_ranges = mayHoldRanges(info);
      definitions.of(*message.channel, &info.problem);
    }
    ++info.count;
    info.last = std::max(info.last, message.received);
    if (out.first == 0) out.first = message.received;
    out.last = std::max(out.last, message.received);
    if (!worthLooking(info)) continue;
    const bags::Definition* definition = definitions.of(*message.channel);
    if (definition == nullptr) continue;
    if (info.count == 1) info.bare_vector = hasBareVector(definition->root());
    if (info.count == 1 && info.speaks_of_ranges) {
      const bool differs = lowerCase(info.type + info.topic).find("tdoa") != std::string::npos;
      info.range_guess = differs ? guessDifferenceFields(definition->root())
                                 : guessRangeFields(definition->root());
    }
    try {
      lookInto(MessageView(*definition, message.data), message, &info, &out);
      info.problem.clear();
    } catch (const bags::BagError& e) {
      if (info.problem.empty()) info.problem = e.what();
    }
  }
  out.damage = reader->damage();
  return out;
}

std::string listing(const Survey& s) {
  std::size_t topic = 5, type = 4;
  for (const auto& [name, info] : s.topics) {
    topic = std::max(topic, name.size());
    type = std::max(type, info.type.size());
  }
  std::string out;
  char line[1024];
  const auto add = [&](const char* t, const char* k, const char* n, const char* r, const char* x) {
    std::snprintf(line, sizeof line, "%-*s  %-*s  %8s  %9s  %s\n",
                  static_cast<int>(std::min<std::size_t>(topic, 200)), t,
                  static_cast<int>(std::min<std::size_t>(type, 200)), k, n, r, x);
    out += line;
  };
  add("topic", "type", "messages", "rate [Hz]", "");
  for (const auto& [name, info] : s.topics) {
    char rate[32];
    std::snprintf(rate, sizeof rate, "%.2f", info.rate());
    std::string note = info.problem;
    if (note.empty() && info.width > 0) {
      note = std::to_string(info.width) + "x" + std::to_string(info.height);
    }
    add(name.c_str(), info.type.c_str(), std::to_string(info.count).c_str(), rate, note.c_str());
  }
  std::snprintf(line, sizeof line, "%.2f s%s\n", toSeconds(s.last - s.first),
                s.whole ? "" : " of it looked at");
  return out + line;
}

}  // namespace vir::bag
