/// What a bag says of its own sizes is not believed: memory is bounded by what the file holds.
#include <gtest/gtest.h>
#include <zstd.h>

#include "bag_fixtures.h"
#include "vir_test_heap.h"
#include "vir_test_temp_folder.h"

namespace vir::bags {
namespace {

using test::bytesOf;
using test::fixture;

/// Buffers that do not depend on the file: of bzip2 4 MB, of zstd and for unpacking 1 MB.
constexpr std::size_t kAlways = std::size_t{8} << 20;
/// SQLite lists the pages of a record by the size that it claims: 4 GB in pages of 4 kB, 8 bytes
/// each, twice while the list grows.
constexpr std::size_t kSqlite = std::size_t{17} << 20;

std::size_t heapFor(const Bytes& bytes) {
  const vir::test::HeapPeak peak;
  try {
    const auto reader = openBag({bytes.data(), bytes.size()}, "x");
    BagMessage m;
    while (reader->next(&m)) continue;
  } catch (const BagError&) {
  }
  return peak.bytes();
}

class BagMemory : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!vir::test::heapIsCounted()) GTEST_SKIP() << "a sanitizer has the heap";
  }
};

/// Four bytes of 0xFF, 0x3F or 0x7F in the place of any four: whatever length stands there.
TEST_F(BagMemory, LengthsThatAreLies) {
  for (const char* name : {"ros1_none.bag", "ros1_bz2.bag", "ros1_lz4.bag", "ros2_none.mcap",
                           "ros2_zstd.mcap", "ros2_lz4.mcap", "ros2_foxy.db3"}) {
    const Bytes whole = bytesOf(fixture(name));
    const bool sqlite = std::string(name).find(".db3") != std::string::npos;
    const std::size_t bound = 4 * whole.size() + (sqlite ? kSqlite : kAlways);
    EXPECT_LE(heapFor(whole), bound) << name;
    // All of the head, then here and there.
    for (std::size_t at = 0; at + 4 <= whole.size(); at += at < 600 ? 1 : 131) {
      for (const std::uint8_t top : {0x3F, 0x7F, 0xFF}) {
        Bytes bytes = whole;
        for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = i == 3 ? top : 0xFF;
        const std::size_t heap = heapFor(bytes);
        ASSERT_LE(heap, bound) << name << " at byte " << at;
      }
    }
  }
}

/// 100 MB of zeros are 4 kB as zstd packs them.
Bytes zeros(std::size_t size) {
  const Bytes plain(size);
  Bytes packed(ZSTD_compressBound(size));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), plain.data(), size, 1));
  return packed;
}

template <typename T>
void put(Bytes* out, T v) {
  for (std::size_t i = 0; i < sizeof v; ++i) {
    out->push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(v) >> (8 * i)));
  }
}

TEST_F(BagMemory, AChunkThatUnpacksToManyTimesItsSize) {
  constexpr std::size_t kSize = std::size_t{100} << 20;
  const Bytes packed = zeros(kSize);
  ASSERT_LT(packed.size(), 100'000u);
  Bytes bytes{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n', 6};
  put<std::uint64_t>(&bytes, 8 + 8 + 8 + 4 + 4 + 4 + 8 + packed.size());
  for (int i = 0; i < 2; ++i) put<std::uint64_t>(&bytes, 0);  // times
  put<std::uint64_t>(&bytes, kSize);
  put<std::uint32_t>(&bytes, 0);  // no checksum
  put<std::uint32_t>(&bytes, 4);
  for (const char c : {'z', 's', 't', 'd'}) bytes.push_back(static_cast<std::uint8_t>(c));
  put<std::uint64_t>(&bytes, packed.size());
  bytes.insert(bytes.end(), packed.begin(), packed.end());
  const auto reader = openBag({bytes.data(), bytes.size()}, "bomb.mcap");
  BagMessage m;
  const vir::test::HeapPeak peak;
  EXPECT_FALSE(reader->next(&m));
  // 64 MB are allowed to any chunk, and the buffer is copied as it grows.
  EXPECT_LT(peak.bytes(), std::size_t{170} << 20);
  ASSERT_FALSE(reader->damage().empty());
  EXPECT_NE(reader->damage()[0].find("more than 200 times its size"), std::string::npos)
      << reader->damage()[0];
}

}  // namespace
}  // namespace vir::bags
