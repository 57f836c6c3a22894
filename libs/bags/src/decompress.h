#pragma once
#include <cstdint>
#include <string>

#include "vir/bags/bytes.h"

namespace vir::bags {

/// More than this is in no chunk or message of a sound recording.
constexpr std::uint64_t kMostBlock = std::uint64_t{1} << 30;

/// "none", "bz2", "lz4" (frames) or "zstd".
bool knownCompression(const std::string& name);

/// Decompresses as far as it goes: `out` has what came out, and the text returned says why that is
/// not all (empty: it is). `size` = what should come out, 0 if not known; never more than
/// kMostBlock, nor than 64 MB and 200 times what goes in. Memory is taken as bytes come out, so
/// that a size that is a lie costs nothing.
std::string decompress(const std::string& name, ByteView in, std::uint64_t size, Bytes* out);

/// A whole file of zstd into another. Throws BagError. Returns what is wrong with its end.
std::string decompressFile(const std::string& from, int to_fd);

}  // namespace vir::bags
