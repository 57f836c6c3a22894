#include "vir/core/crc.h"

namespace vir {
inline namespace core {

std::uint16_t crc16Ccitt(const std::uint8_t* bytes, std::size_t size) {
  unsigned crc = 0xFFFF;
  for (std::size_t i = 0; i < size; ++i) {
    crc ^= static_cast<unsigned>(bytes[i]) << 8;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc & 0x8000) != 0 ? (crc << 1) ^ 0x1021 : crc << 1;
    }
    crc &= 0xFFFF;
  }
  return static_cast<std::uint16_t>(crc);
}

std::uint16_t crc16Mavlink(const std::uint8_t* bytes, std::size_t size, std::uint16_t start) {
  unsigned crc = start;
  for (std::size_t i = 0; i < size; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? (crc >> 1) ^ 0x8408 : crc >> 1;
  }
  return static_cast<std::uint16_t>(crc);
}

}  // namespace core
}  // namespace vir
