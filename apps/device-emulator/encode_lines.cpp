/// Devices that print a line per range.
#include "messages.h"
#include "wire.h"

namespace vir::emulator {

std::string encodeArduino(const RangeMessage& m) {
  std::string out;
  for (const RangeItem& item : m.items) {
    require(item.id >= 0 && item.id <= 0xFFFF, "a DW1000 short address has 16 bits");
    out += printed("from: 0x%X\tRange: %.3f m\tRX power: -67.19 dBm\r\n",
                   static_cast<unsigned>(item.id), item.range_m);
  }
  return out;
}

std::string encodeJson(const RangeMessage& m) {
  std::string out;
  for (const RangeItem& item : m.items) {
    if (item.reference) {
      out += printed("{\"utime\":%lld,\"uid\":%d,\"ouid\":%lld,\"ruid\":%lld,\"tdoa\":[%.6f]}\n",
                     static_cast<long long>(m.device_time / 1000), m.own_id,
                     static_cast<long long>(item.id), static_cast<long long>(*item.reference),
                     item.range_m);
      continue;
    }
    out += printed("{\"utime\":%lld,\"uid\":%d,\"ouid\":%lld,\"raz\":[%.6f],\"rssi\":[-79.3]}\n",
                   static_cast<long long>(m.device_time / 1000), m.own_id,
                   static_cast<long long>(item.id), item.range_m);
  }
  return out;
}

}  // namespace vir::emulator
