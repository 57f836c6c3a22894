#include "own_labels.h"

#include <sstream>

#include "range_fields.h"
#include "vir/core/parse_number.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/topic_metadata.h"

namespace vir::bag {
namespace {

using namespace rawlog;

std::string textIn(const TopicInfo& info, const char* name) {
  const auto found = info.metadata.find(name);
  return found == info.metadata.end() ? std::string() : found->second;
}

/// `/peer`, `/anchor_3`: what files of before called them.
std::string labelByTopic(const std::string& topic) {
  const std::string anchor = "/anchor_";
  std::uint64_t id = 0;
  if (topic == "/peer") return kPeerLabel;
  if (topic.compare(0, anchor.size(), anchor) != 0) return {};
  return parseNumber(topic.substr(anchor.size()), &id) ? anchorLabel(id) : std::string();
}

bool isRangeLabel(const std::string& label) {
  std::uint64_t number = 0;
  const std::string stem = furtherLabel(kRangeLabel, "");
  return label == kPeerLabel || isDeployedAnchorLabel(label) ||
         (label.compare(0, stem.size(), stem) == 0 &&
          parseNumber(label.substr(stem.size()), &number));
}

}  // namespace

OwnLabel ownLabelOf(const TopicInfo& info) {
  OwnLabel out;
  const std::string label = textIn(info, kTopicLabel);
  if (isOwnRange(info.type)) {
    out.label = isRangeLabel(label) ? label : labelByTopic(info.topic);
  } else if (info.type == "geometry_msgs/PoseWithCovarianceStamped" &&
             (isDeployedAnchorLabel(label) || broadcastSourceOf(label))) {
    out.label = label;
  }
  if (out.label.empty()) return out;
  out.anchor = textIn(info, kTopicAnchor);
  std::istringstream antenna(textIn(info, kTopicAntenna));
  Vec3 p;
  for (int i = 0; i < 3; ++i) {
    std::string word;
    if (!(antenna >> word) || !parseNumber(word, &p[i])) return out;
  }
  if (p.allFinite()) out.antenna = p;
  return out;
}

std::string withAnchor(const std::string& label, std::uint64_t anchor) {
  if (isDeployedAnchorLabel(label)) return anchorLabel(anchor);
  auto source = broadcastSourceOf(label);
  if (!source || !source->anchor) return label;
  source->anchor = anchor;
  return broadcastLabel(*source);
}

}  // namespace vir::bag
