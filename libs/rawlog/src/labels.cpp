#include "vir/rawlog/labels.h"

#include <charconv>

namespace vir::rawlog {
namespace {

const std::string kDeployedAnchor = "ANCHOR:";
const std::string kSentAnchor = ":ANCHOR:";  // behind the sender's id

/// All of `text` from `from` on is a number.
std::optional<std::uint64_t> numberAt(const std::string& text, std::size_t from) {
  std::uint64_t value = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data() + from, last, value);
  if (error != std::errc() || end != last) return std::nullopt;
  return value;
}

}  // namespace

bool isDeployedAnchorLabel(const std::string& label) { return deployedAnchorOf(label).has_value(); }

std::optional<std::uint64_t> deployedAnchorOf(const std::string& label) {
  if (label.compare(0, kDeployedAnchor.size(), kDeployedAnchor) != 0) return std::nullopt;
  return numberAt(label, kDeployedAnchor.size());
}

bool isBroadcastLabel(const std::string& label, const std::string& peer_label) {
  const std::size_t n = peer_label.size();
  return label.size() > n + 1 && label[n] == ':' && label.compare(0, n, peer_label) == 0;
}

std::optional<BroadcastSource> broadcastSourceOf(const std::string& label,
                                                 const std::string& peer_label) {
  if (!isBroadcastLabel(label, peer_label)) return std::nullopt;
  BroadcastSource out;
  const char* const last = label.data() + label.size();
  const auto id = std::from_chars(label.data() + peer_label.size() + 1, last, out.peer);
  if (id.ec != std::errc()) return std::nullopt;
  if (id.ptr == last) return out;
  const auto rest = static_cast<std::size_t>(id.ptr - label.data());
  if (label.compare(rest, kSentAnchor.size(), kSentAnchor) != 0) return std::nullopt;
  out.anchor = numberAt(label, rest + kSentAnchor.size());
  if (!out.anchor) return std::nullopt;
  return out;
}

std::string broadcastLabel(const BroadcastSource& source, const std::string& peer_label) {
  std::string label = peer_label + ":" + std::to_string(source.peer);
  if (source.anchor) label += kSentAnchor + std::to_string(*source.anchor);
  return label;
}

}  // namespace vir::rawlog
