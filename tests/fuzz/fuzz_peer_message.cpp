/// Any bytes are decoded without harm, and what is decoded can be sent again.
///   fuzz_peer_message -max_len=64 -max_total_time=60
#include <cstdlib>
#include <cstring>

#include "fuzz_damage.h"
#include "vir/team/peer_message.h"

namespace {

std::uint32_t crc32(const std::uint8_t* bytes, std::size_t size) {
  std::uint32_t crc = ~0u;
  for (std::size_t i = 0; i < size; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) ? (crc >> 1) ^ 0xEDB88320u : crc >> 1;
  }
  return ~crc;
}

void tryOne(const std::uint8_t* data, std::size_t size) {
  vir::team::PeerMessage message;
  if (vir::team::decode(data, size, &message) != vir::team::PeerDecoding::ok) return;
  if (!message.p_W.allFinite() || !message.covariance.allFinite()) std::abort();
  // Not farther than encode() accepts.
  if (message.p_W.cwiseAbs().maxCoeff() > 2e5) return;
  if (message.anchor && message.anchor->p_W.cwiseAbs().maxCoeff() > 2e5) return;
  const vir::team::PeerPacket again = vir::team::encode(message);
  if (vir::team::decode(again.data(), again.size(), &message) != vir::team::PeerDecoding::ok)
    std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  vir::fuzz::count(size);
  tryOne(data, size);
  if (size != vir::team::kPeerMessageBytes) return 0;
  // Chance never hits the checksum: set it, so that what lies behind it is tried too.
  std::uint8_t sealed[vir::team::kPeerMessageBytes];
  std::memcpy(sealed, data, size);
  sealed[0] = 0xA7;
  sealed[1] = 1;
  const std::uint32_t crc = crc32(sealed, size - 4);
  for (std::size_t i = 0; i < 4; ++i) {
    sealed[size - 4 + i] = static_cast<std::uint8_t>(crc >> (8 * i));
  }
  tryOne(sealed, size);
  return 0;
}
