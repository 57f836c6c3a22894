#include "messages.h"
#include "wire.h"

namespace vir::emulator {

std::string encodeTrek1000(const RangeMessage& m) {
  unsigned mask = 0, mm[8] = {};
  bool eight = false;
  for (const RangeItem& item : m.items) {
    require(item.id >= 0 && item.id < 8, "TREK1000 knows ids 0 to 7 only");
    eight |= item.id >= 4;
    mask |= 1U << item.id;
    mm[item.id] = static_cast<unsigned>(rounded(item.range_m * 1000));
  }
  std::string line = printed("mc %02x", mask);
  for (int i = 0; i < (eight ? 8 : 4); ++i) line += printed(" %08x", mm[i]);
  return line + printed(" 095f %02x %08x t%d:0\r\n", m.sequence & 0xFF,
                        static_cast<unsigned>((m.device_time / 1000000) & 0xFFFFFFFF), m.own_id);
}

}  // namespace vir::emulator
