/// A megabyte of random and of damaged bytes through every parser: no range out of noise, bounded
/// memory. The same with sanitizers and many more bytes: tests/fuzz.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "uwb_streams.h"
#include "vir/core/random.h"

namespace vir::uwb::test {
namespace {

constexpr std::size_t kBytes = 1 << 20;
/// Two lines or blocks, or a frame and a piece of input; `auto` holds those of all protocols.
constexpr std::size_t kMostHeld = 6000, kMostHeldByAuto = 8 * kMostHeld;

std::size_t mostHeld(const std::string& protocol) {
  return protocol == "auto" ? kMostHeldByAuto : kMostHeld;
}

std::vector<std::string> protocolsAndAuto() {
  std::vector<std::string> names = protocolNames();
  names.push_back("auto");
  return names;
}

class Noise : public ::testing::TestWithParam<std::string> {
 protected:
  int below(int n) { return static_cast<int>(random_.uniform() * n); }
  Random random_{20240817};
};

TEST_P(Noise, RandomBytesGiveNoRange) {
  const auto parser = makeParser(GetParam(), {});
  std::vector<RangeReading> readings;
  for (std::size_t fed = 0; fed < kBytes;) {
    Bytes piece(static_cast<std::size_t>(1 + below(300)), 0);
    for (char& c : piece) c = static_cast<char>(below(256));
    feed(parser.get(), piece, &readings);
    ASSERT_LE(parser->buffered(), mostHeld(GetParam()));
    fed += piece.size();
  }
  EXPECT_TRUE(readings.empty()) << shown(readings);
}

/// Characters that make up the messages, in random order: harder than random bytes.
TEST_P(Noise, RandomTextGivesNoRange) {
  const std::string alphabet = "0123456789ABCDEFabcdef.,:;[]{}()=-mcrta \t\r\n\"DISTANxPOS";
  const auto parser = makeParser(GetParam(), {});
  std::vector<RangeReading> readings;
  for (std::size_t fed = 0; fed < kBytes;) {
    Bytes piece(static_cast<std::size_t>(1 + below(300)), 0);
    for (char& c : piece)
      c = alphabet[static_cast<std::size_t>(below(static_cast<int>(alphabet.size())))];
    feed(parser.get(), piece, &readings);
    ASSERT_LE(parser->buffered(), mostHeld(GetParam()));
    fed += piece.size();
  }
  EXPECT_TRUE(readings.empty()) << shown(readings);
}

TEST_P(Noise, NoEndOfLineNoGrowth) {
  const auto parser = makeParser(GetParam(), {});
  std::vector<RangeReading> readings;
  for (int i = 0; i < 300; ++i) {
    feed(parser.get(), Bytes(4096, i % 2 == 0 ? 'D' : '\x55'), &readings);
    ASSERT_LE(parser->buffered(), mostHeld(GetParam()));
  }
  EXPECT_TRUE(readings.empty());
}

/// Good messages, each with a byte changed, lost or doubled now and then. Where there is no
/// checksum a changed digit passes, so the test is that ids and sizes stay within what was sent,
/// and that what was not touched comes through.
TEST_P(Noise, DamagedStreams) {
  if (GetParam() == "auto") return;
  Bytes good;
  std::size_t per_copy = 0;
  for (const Stream& s : goodStreams()) {
    if (s.protocol != GetParam()) continue;
    good = s.bytes;
    per_copy = parse(s.protocol, s.bytes).readings.size();
  }
  const auto parser = makeParser(GetParam(), {});
  std::vector<RangeReading> readings;
  std::size_t sent = 0;
  for (std::size_t fed = 0; fed < kBytes; fed += good.size()) {
    Bytes copy = good;
    for (int hits = below(4); hits > 0; --hits) {
      const auto at = static_cast<std::size_t>(below(static_cast<int>(copy.size())));
      const int kind = below(4);
      if (kind == 0) copy.erase(at, 1);
      if (kind == 1) copy.insert(at, 1, copy[at]);
      if (kind == 2) copy[at] = static_cast<char>(below(256));
      if (kind == 3) copy[at] = static_cast<char>(copy[at] ^ (1 << below(8)));
      if (copy.empty()) copy = good;
    }
    sent += per_copy;
    feed(parser.get(), copy, &readings);
    ASSERT_LE(parser->buffered(), mostHeld(GetParam()));
  }
  EXPECT_LE(readings.size(), sent + sent / 20);
  EXPECT_GE(readings.size(), sent / 3);
  for (const RangeReading& r : readings) {
    ASSERT_TRUE(r.range_m >= 0.05 && r.range_m <= 300);
    ASSERT_GE(r.responder, 0);
  }
  EXPECT_GT(parser->counters().corrupt, 0);
}

INSTANTIATE_TEST_SUITE_P(Uwb, Noise, ::testing::ValuesIn(protocolsAndAuto()),
                         [](const auto& i) { return i.param; });

}  // namespace
}  // namespace vir::uwb::test
