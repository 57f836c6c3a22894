#pragma once
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "byte_source.h"
#include "range_parser.h"
#include "vir/core/options.h"

namespace vir::uwb {

/// Settings of a section with driver = UwbSerial.
struct UwbOptions {
  ByteSourceOptions source;
  std::string protocol = "auto";
  std::string anchor_ids, peer_ids;  ///< as written; see parseIds()
  std::string unknown_ids = "drop";
  int own_id = -1;  ///< -1 = whoever measured
  RangeLimits limits;
  double std_error_m = 0.1;
  std::vector<double> antenna_m = {0, 0, 0};  ///< in the body frame
  std::string stamp = "auto";
  double latency_s = 0;
  bool dialogue = true;
  double poll_hz = 10;
  double tell_hz = 0;  ///< 0 = tells the other robots nothing
};

void describe(OptionVisitor& v, UwbOptions& o);

/// Numbers from 0 to 2^31 - 1 separated by blanks or commas, decimal or 0x hexadecimal. Throws
/// std::invalid_argument that says which word is none.
std::set<std::int64_t> parseIds(const std::string& text);

}  // namespace vir::uwb
