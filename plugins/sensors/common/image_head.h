#pragma once
#include <cstddef>
#include <cstdint>

namespace vir {

/// False for a PNG, JPEG, BMP or TIFF that claims more pixels than its bytes can hold: decoders
/// make room for what is claimed before they look at the rest. 16 megapixels are allowed to any
/// file (a black image packs a thousandfold); other kinds of files are not looked into.
bool pixelsFit(const std::uint8_t* bytes, std::size_t size);

}  // namespace vir
