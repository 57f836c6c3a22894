#pragma once
#include <cstddef>
#include <cstdint>

namespace vir {
inline namespace core {

/// CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xFFFF, not reflected; "123456789" -> 0x29B1.
std::uint16_t crc16Ccitt(const std::uint8_t* bytes, std::size_t size);

/// CRC-16/MCRF4XX, which MAVLink calls X.25: polynomial 0x1021 reflected, start 0xFFFF, no final
/// inversion; "123456789" -> 0x6F91. `crc` continues an earlier one.
std::uint16_t crc16Mavlink(const std::uint8_t* bytes, std::size_t size, std::uint16_t crc = 0xFFFF);

}  // namespace core
}  // namespace vir
