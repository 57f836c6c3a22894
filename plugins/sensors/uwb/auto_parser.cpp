#include "auto_parser.h"

namespace vir::uwb {

AutoParser::AutoParser(const RangeLimits& limits) : RangeParser(limits) { startSearch(); }

void AutoParser::startSearch() {
  chosen_ = nullptr;
  ++choices_;
  messages_seen_ = 0;
  idle_bytes_ = 0;
  candidates_.clear();
  for (const std::string& name : protocolNames()) {
    // That one answers only when asked.
    if (name != "dwm1001_tlv") candidates_.push_back(makeParser(name, limits_));
  }
}

std::string AutoParser::name() const { return chosen_ ? chosen_->name() : "auto"; }

void AutoParser::feed(const std::uint8_t* bytes, std::size_t size, std::vector<RangeReading>* out) {
  // Byte by byte: what is chosen, and when, must not depend on the pieces.
  for (std::size_t i = 0; i < size; ++i) {
    if (chosen_ == nullptr) {
      search(bytes[i], out);
      continue;
    }
    chosen_->feed(bytes + i, 1, out);
    ++idle_bytes_;
    if (chosen_->counters().messages != messages_seen_) {
      messages_seen_ = chosen_->counters().messages;
      idle_bytes_ = 0;
    } else if (idle_bytes_ >= kGiveUpBytes) {
      past_ += chosen_->counters();
      startSearch();
    }
  }
}

void AutoParser::search(std::uint8_t byte, std::vector<RangeReading>* out) {
  std::vector<RangeReading> readings;
  ++unrecognised_bytes_;
  for (auto& candidate : candidates_) {
    readings.clear();
    candidate->feed(&byte, 1, &readings);
    if (candidate->counters().messages == candidate->counters().ignored) continue;
    chosen_ = candidate.get();
    ++choices_;
    messages_seen_ = chosen_->counters().messages;
    idle_bytes_ = 0;
    unrecognised_bytes_ = 0;
    out->insert(out->end(), readings.begin(), readings.end());
    return;
  }
}

void AutoParser::reset() {
  for (auto& candidate : candidates_) candidate->reset();
}

std::size_t AutoParser::buffered() const {
  std::size_t sum = 0;
  for (const auto& candidate : candidates_) sum += candidate->buffered();
  return sum;
}

std::vector<NodeData> AutoParser::takeData() {
  return chosen_ != nullptr ? chosen_->takeData() : std::vector<NodeData>();
}

const ParserCounters& AutoParser::counters() const {
  sum_ = past_;
  if (chosen_ != nullptr) sum_ += chosen_->counters();
  sum_.skipped_bytes += unrecognised_bytes_;
  return sum_;
}

}  // namespace vir::uwb
