#include "messages.h"
#include "wire.h"

namespace vir::emulator {

std::string encodeQm33(const RangeMessage& m) {
  std::string block = printed(
      "SESSION_INFO_NTF: {session_handle=1, sequence_number=%u, block_index=%u, n_measurements=%zu",
      m.sequence, m.sequence, m.items.size());
  for (std::size_t i = 0; i < m.items.size(); ++i) {
    block += printed("\r\n [mac_address=0x%04x, status=\"SUCCESS\", distance[cm]=%lld]%s",
                     static_cast<unsigned>(m.items[i].id), rounded(m.items[i].range_m * 100),
                     i + 1 < m.items.size() ? ";" : "");
  }
  return block + "}\r\n";
}

}  // namespace vir::emulator
