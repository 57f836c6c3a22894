#include <stdexcept>

#include "arduino_parser.h"
#include "at_range_parser.h"
#include "auto_parser.h"
#include "dwm1001_parser.h"
#include "dwm1001_tlv_parser.h"
#include "json_parser.h"
#include "nlink_parser.h"
#include "qm33_parser.h"
#include "range_parser.h"
#include "trek1000_parser.h"

namespace vir::uwb {

const std::vector<std::string>& protocolNames() {
  static const std::vector<std::string> names = {
      "dwm1001", "dwm1001_tlv", "trek1000", "at_range", "qm33", "nlink", "dw1000_arduino", "json"};
  return names;
}

std::unique_ptr<RangeParser> makeParser(const std::string& protocol, const RangeLimits& limits) {
  if (protocol == "auto") return std::make_unique<AutoParser>(limits);
  if (protocol == "dwm1001") return std::make_unique<Dwm1001Parser>(limits);
  if (protocol == "dwm1001_tlv") return std::make_unique<Dwm1001TlvParser>(limits);
  if (protocol == "trek1000") return std::make_unique<Trek1000Parser>(limits);
  if (protocol == "at_range") return std::make_unique<AtRangeParser>(limits);
  if (protocol == "qm33") return std::make_unique<Qm33Parser>(limits);
  if (protocol == "nlink") return std::make_unique<NlinkParser>(limits);
  if (protocol == "dw1000_arduino") return std::make_unique<ArduinoParser>(limits);
  if (protocol == "json") return std::make_unique<JsonParser>(limits);
  throw std::invalid_argument("no UWB protocol is called " + protocol);
}

}  // namespace vir::uwb
