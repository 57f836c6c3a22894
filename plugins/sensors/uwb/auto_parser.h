#pragma once
/// `protocol = auto`: tries every protocol that a device sends unasked, and stays with the one that
/// first yields a valid message. Each is strict enough (whole grammar, or lengths and a sum) that
/// one message tells. When the chosen one yields nothing valid for long, the search begins anew.
#include "range_parser.h"

namespace vir::uwb {

class AutoParser : public RangeParser {
 public:
  /// Without a valid message for so many bytes the choice was wrong, or another device is there.
  static constexpr std::uint64_t kGiveUpBytes = 16384;

  explicit AutoParser(const RangeLimits& limits);
  /// The chosen protocol's name, or "auto" as long as there is none.
  std::string name() const override;
  long choices() const override { return choices_; }
  void feed(const std::uint8_t* bytes, std::size_t size, std::vector<RangeReading>* out) override;
  void reset() override;
  std::size_t buffered() const override;
  TimeNs clockWrap() const override { return chosen_ ? chosen_->clockWrap() : 0; }
  bool clockTrusted() const override { return chosen_ != nullptr && chosen_->clockTrusted(); }
  /// Of the protocols chosen so far; bytes that none recognised count as skipped.
  const ParserCounters& counters() const override;
  std::vector<NodeData> takeData() override;

 private:
  void startSearch();
  void search(std::uint8_t byte, std::vector<RangeReading>* out);

  std::vector<std::unique_ptr<RangeParser>> candidates_;
  RangeParser* chosen_ = nullptr;
  long messages_seen_ = 0, choices_ = 0;
  std::uint64_t idle_bytes_ = 0;
  std::uint64_t unrecognised_bytes_ = 0;
  ParserCounters past_;         ///< of protocols that were given up
  mutable ParserCounters sum_;  ///< what counters() returns
};

}  // namespace vir::uwb
