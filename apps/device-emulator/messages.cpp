#include "messages.h"

#include <utility>

namespace vir::emulator {
namespace {

const std::pair<const char*, RangeEncoder> kRangeEncoders[] = {{"dwm1001", encodeDwm1001},
                                                               {"dwm1001_tlv", encodeDwm1001Tlv},
                                                               {"trek1000", encodeTrek1000},
                                                               {"at_range", encodeAtRange},
                                                               {"qm33", encodeQm33},
                                                               {"nlink", encodeNlink},
                                                               {"dw1000_arduino", encodeArduino},
                                                               {"json", encodeJson}};

const std::pair<const char*, ImuEncoder> kImuEncoders[] = {{"text", encodeImuText},
                                                           {"binary", encodeImuBinary},
                                                           {"mavlink", encodeMavlinkHighres},
                                                           {"mavlink_scaled", encodeMavlinkScaled}};

}  // namespace

RangeEncoder rangeEncoder(const std::string& protocol) {
  for (const auto& [name, encoder] : kRangeEncoders) {
    if (name == protocol) return encoder;
  }
  return nullptr;
}

ImuEncoder imuEncoder(const std::string& protocol) {
  for (const auto& [name, encoder] : kImuEncoders) {
    if (name == protocol) return encoder;
  }
  return nullptr;
}

std::vector<std::string> rangeProtocols() {
  std::vector<std::string> names;
  for (const auto& e : kRangeEncoders) names.push_back(e.first);
  return names;
}

std::vector<std::string> imuProtocols() {
  std::vector<std::string> names;
  for (const auto& e : kImuEncoders) names.push_back(e.first);
  return names;
}

}  // namespace vir::emulator
