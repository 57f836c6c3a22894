#pragma once
#include <cstddef>
#include <cstdint>

#include "vir/core/time.h"

namespace vir {
inline namespace types {

/// A gray image that belongs to somebody else: 8 bits per pixel, rows from the top.
struct Image {
  TimeNs t = 0;  ///< on the camera's clock
  int width = 0, height = 0;
  const std::uint8_t* pixels = nullptr;
  std::size_t stride = 0;  ///< bytes from one row to the next; 0 = width
  int camera = 0;          ///< of a rig
};

}  // namespace types
}  // namespace vir
