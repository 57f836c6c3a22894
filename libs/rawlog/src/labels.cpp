#include "vir/rawlog/labels.h"

#include <algorithm>
#include <string_view>

#include "vir/core/parse_number.h"

namespace vir::rawlog {
namespace {

const std::string kDeployedAnchor = "ANCHOR:";
const std::string kDifference = "TDOA:";
const std::string kSentAnchor = ":ANCHOR:", kSentWorld = ":WORLD:";  // behind the sender's id

/// All of `text` from `from` on is a number.
std::optional<std::uint64_t> numberAt(const std::string& text, std::size_t from) {
  std::uint64_t value = 0;
  if (!parseNumber(std::string_view(text).substr(from), &value)) return std::nullopt;
  return value;
}

}  // namespace

bool isDeployedAnchorLabel(const std::string& label) { return deployedAnchorOf(label).has_value(); }

std::string anchorLabel(std::uint64_t id) { return kDeployedAnchor + std::to_string(id); }

std::string furtherLabel(const std::string& first, const std::string& number) {
  return first.substr(0, first.find_last_not_of("0123456789") + 1) + number;
}

std::optional<std::uint64_t> deployedAnchorOf(const std::string& label) {
  if (label.compare(0, kDeployedAnchor.size(), kDeployedAnchor) != 0) return std::nullopt;
  return numberAt(label, kDeployedAnchor.size());
}

std::optional<std::uint64_t> differenceReferenceOf(const std::string& label) {
  if (label.compare(0, kDifference.size(), kDifference) != 0) return std::nullopt;
  return numberAt(label, kDifference.size());
}

std::string differenceLabel(std::uint64_t reference) {
  return kDifference + std::to_string(reference);
}

std::string differencesName() { return kDifference.substr(0, kDifference.find(':')); }

bool isBroadcastLabel(const std::string& label, const std::string& peer_label) {
  const std::size_t n = peer_label.size();
  return label.size() > n + 1 && label[n] == ':' && label.compare(0, n, peer_label) == 0;
}

std::optional<BroadcastSource> broadcastSourceOf(const std::string& label,
                                                 const std::string& peer_label) {
  if (!isBroadcastLabel(label, peer_label)) return std::nullopt;
  BroadcastSource out;
  const std::string_view text = label;
  const std::size_t id = peer_label.size() + 1, behind = std::min(text.find(':', id), text.size());
  if (!parseNumber(text.substr(id, behind - id), &out.peer)) return std::nullopt;
  if (behind == text.size()) return out;
  if (text.compare(behind, kSentWorld.size(), kSentWorld) == 0) {
    int world = 0;
    if (!parseNumber(text.substr(behind + kSentWorld.size()), &world) || world < 0) {
      return std::nullopt;
    }
    out.world = world;
    return out;
  }
  if (text.compare(behind, kSentAnchor.size(), kSentAnchor) != 0) return std::nullopt;
  out.anchor = numberAt(label, behind + kSentAnchor.size());
  if (!out.anchor) return std::nullopt;
  return out;
}

std::string broadcastLabel(const BroadcastSource& source, const std::string& peer_label) {
  std::string label = peer_label + ":" + std::to_string(source.peer);
  if (source.anchor) label += kSentAnchor + std::to_string(*source.anchor);
  if (source.world) label += kSentWorld + std::to_string(*source.world);
  return label;
}

}  // namespace vir::rawlog
