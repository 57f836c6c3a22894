#pragma once
/// Qorvo DWM3001CDK and other boards with the QM33 SDK's command line: per ranging round
///   SESSION_INFO_NTF: {session_handle=1, sequence_number=1, block_index=1, n_measurements=2
///    [mac_address=0x0001, status="SUCCESS", distance[cm]=245];
///    [mac_address=0x0002, status="RX_TIMEOUT"]}
/// on one line or several. A block counts if it is complete: n_measurements items, each successful
/// one with a distance. Further `name=value` fields of an item (angles, RSSI[dBm]) may follow.
#include "range_parser.h"

namespace vir {
class TextScanner;
}

namespace vir::uwb {

class Qm33Parser : public LineRangeParser {
 public:
  static constexpr std::size_t kLongestBlock = 4096;
  using LineRangeParser::LineRangeParser;
  std::string name() const override { return "qm33"; }
  void reset() override;
  std::size_t buffered() const override { return LineRangeParser::buffered() + block_.size(); }

 protected:
  Verdict parseLine(std::string_view line, std::vector<RangeReading>* out) override;

 private:
  Verdict parseBlock(std::vector<RangeReading>* out);
  bool parseItem(TextScanner* s);

  std::string block_;  ///< what has come of a block; empty outside
  std::vector<RangeReading> found_;
  long failed_ = 0;
};

}  // namespace vir::uwb
