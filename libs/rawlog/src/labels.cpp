#include "vir/rawlog/labels.h"

#include <charconv>

namespace vir::rawlog {
namespace {

const std::string kDroppedAnchor = "ANCHOR:";

}  // namespace

bool isDroppedAnchorLabel(const std::string& label) { return droppedAnchorOf(label).has_value(); }

std::optional<std::uint64_t> droppedAnchorOf(const std::string& label) {
  if (label.compare(0, kDroppedAnchor.size(), kDroppedAnchor) != 0) return std::nullopt;
  std::uint64_t id = 0;
  const char* const first = label.data() + kDroppedAnchor.size();
  const char* const last = label.data() + label.size();
  const auto [end, error] = std::from_chars(first, last, id);
  if (error != std::errc() || end != last) return std::nullopt;
  return id;
}

std::string droppedAnchorLabel(std::uint64_t id) { return kDroppedAnchor + std::to_string(id); }

}  // namespace vir::rawlog
