#include "messages.h"
#include "wire.h"

namespace vir::emulator {

std::string encodeAtRange(const RangeMessage& m) {
  require(m.items.size() <= 8, "an AT+RANGE line holds at most 8 ranges");
  std::string ranges, rssi, ids;
  for (std::size_t i = 0; i < 8; ++i) {
    const bool used = i < m.items.size();
    const char* comma = i == 0 ? "" : ",";
    ranges += printed("%s%lld", comma, used ? rounded(m.items[i].range_m * 100) : 0);
    rssi += printed("%s%.2f", comma, used ? -79.31 : 0.0);
    ids += printed("%s%lld", comma, used ? static_cast<long long>(m.items[i].id) : -1LL);
  }
  return printed("AT+RANGE=tid:%d,mask:%02X,seq:%u,range:(", m.own_id, (1U << m.items.size()) - 1,
                 m.sequence & 0xFF) +
         ranges + "),rssi:(" + rssi + "),ancid:(" + ids + ")\r\n";
}

}  // namespace vir::emulator
