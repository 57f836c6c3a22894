#include "messages.h"
#include "wire.h"

namespace vir::emulator {

std::string encodeDwm1001(const RangeMessage& m) {
  require(m.items.size() <= 15, "a DWM1001 line holds at most 15 ranges");
  std::string line = printed("DIST,%zu", m.items.size());
  for (std::size_t i = 0; i < m.items.size(); ++i) {
    require(m.items[i].id >= 0 && m.items[i].id <= 0xFFFF, "a DWM1001 id has 16 bits");
    line += printed(",AN%zu,%04X,1.00,-2.50,0.00,%.2f", i, static_cast<unsigned>(m.items[i].id),
                    m.items[i].range_m);
  }
  if (m.items.size() >= 3) line += ",POS,6.95,5.37,-1.97,52";
  return line + "\r\n";
}

std::string encodeDwm1001Tlv(const RangeMessage& m) {
  require(m.items.size() <= 12, "a DWM1001 answer holds at most 12 ranges");
  std::string out("\x40\x01\x00\x41\x0D", 5);
  put(&out, 6950, 4);
  put(&out, 5370, 4);
  put(&out, static_cast<std::uint32_t>(-1970), 4);
  put(&out, 52, 1);
  put(&out, 0x49, 1);
  put(&out, 1 + 20 * m.items.size(), 1);
  put(&out, m.items.size(), 1);
  for (const RangeItem& item : m.items) {
    require(item.id >= 0 && item.id <= 0xFFFF, "a DWM1001 id has 16 bits");
    put(&out, static_cast<std::uint64_t>(item.id), 2);
    put(&out, static_cast<std::uint64_t>(rounded(item.range_m * 1000)), 4);
    put(&out, 100, 1);
    put(&out, 1000, 4);
    put(&out, static_cast<std::uint32_t>(-2500), 4);
    put(&out, 0, 4);
    put(&out, 100, 1);
  }
  return out;
}

}  // namespace vir::emulator
