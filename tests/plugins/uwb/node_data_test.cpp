/// Data that LinkTrack nodes send to each other (NodeFrame0).
#include <gtest/gtest.h>

#include "auto_parser.h"
#include "messages.h"
#include "uwb_streams.h"

namespace vir::uwb::test {
namespace {

/// An example of the format: nodes 0 and 2 have sent 9 and 37 bytes.
Bytes example() {
  Bytes b("\x55\x02", 2);
  put(&b, 66, 2);
  put(&b, 1, 1);
  put(&b, 0, 1);
  put(&b, 0x88C32CD1, 4);
  put(&b, 2, 1);
  for (const auto& [id, size] : {std::pair{0, 9}, {2, 37}}) {
    put(&b, 2, 1);
    put(&b, static_cast<std::uint64_t>(id), 1);
    put(&b, static_cast<std::uint64_t>(size), 2);
    for (int i = 0; i < size; ++i) put(&b, static_cast<std::uint64_t>(i + id), 1);
  }
  seal(&b);
  return b;
}

TEST(NodeData, ComesOutByNode) {
  const auto parser = makeParser("nlink", {});
  std::vector<RangeReading> readings;
  feed(parser.get(), example(), &readings);
  EXPECT_TRUE(readings.empty());
  EXPECT_EQ(parser->counters().messages, 1);
  EXPECT_EQ(parser->counters().corrupt, 0);
  const std::vector<NodeData> data = parser->takeData();
  ASSERT_EQ(data.size(), 2u);
  EXPECT_EQ(data[0].sender, 0);
  EXPECT_EQ(data[0].bytes.size(), 9u);
  EXPECT_EQ(data[1].sender, 2);
  ASSERT_EQ(data[1].bytes.size(), 37u);
  EXPECT_EQ(data[1].bytes[36], 38);
  EXPECT_TRUE(parser->takeData().empty());
}

TEST(NodeData, PiecesDoNotMatterAndAutoKnowsIt) {
  AutoParser parser({});
  std::vector<RangeReading> readings;
  const Bytes bytes = example() + nodeFrame3({{4, 5000}}) + example();
  for (const char c : bytes) feed(&parser, std::string_view(&c, 1), &readings);
  EXPECT_EQ(parser.name(), "nlink");
  EXPECT_EQ(shown(readings), "4=5.000 ");
  EXPECT_EQ(parser.takeData().size(), 4u);
}

TEST(NodeData, OfTheEmulatorIsUnderstood) {
  const std::string sent("\x00\x55\x02\xFF text", 9);
  const auto parser = makeParser("nlink", {});
  std::vector<RangeReading> readings;
  feed(parser.get(), emulator::encodeNlinkData({3, 200, sent}), &readings);
  const std::vector<NodeData> data = parser->takeData();
  ASSERT_EQ(data.size(), 1u);
  EXPECT_EQ(data[0].sender, 200);
  EXPECT_EQ(std::string(data[0].bytes.begin(), data[0].bytes.end()), sent);
  EXPECT_THROW(emulator::encodeNlinkData({3, 256, sent}), std::invalid_argument);
  EXPECT_THROW(emulator::encodeNlinkData({3, 2, std::string(1025, 'x')}), std::invalid_argument);
}

/// Every byte changed in every bit, and every byte lost: no data, and what follows is read.
TEST(NodeData, DamageIsNoticed) {
  const Bytes good = example(), next = nodeFrame3({{4, 5000}});
  const auto expectNone = [&](const Bytes& damaged, std::size_t at) {
    const auto parser = makeParser("nlink", {});
    std::vector<RangeReading> readings;
    // A length that became too large is waited for: the bytes after it are not lost.
    feed(parser.get(), damaged + next + Bytes(2100, '\0'), &readings);
    EXPECT_TRUE(parser->takeData().empty()) << at;
    EXPECT_EQ(shown(readings), "4=5.000 ") << at;
    EXPECT_GE(parser->counters().corrupt + static_cast<long>(parser->counters().skipped_bytes), 1);
  };
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      Bytes damaged = good;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
      expectNone(damaged, at);
    }
    Bytes lost = good;
    lost.erase(at, 1);
    if (lost != good) expectNone(lost, at);
  }
}

/// Counts and lengths that do not fit what there is.
TEST(NodeData, LengthsThatDoNotFitAreRefused) {
  for (const auto& [at, value] : {std::pair<std::size_t, int>{10, 255},
                                  {10, 1},
                                  {13, 255},
                                  {14, 255},
                                  {26, 255},
                                  {2, 12},
                                  {3, 255}}) {
    Bytes b = example();
    b.pop_back();
    b[at] = static_cast<char>(value);
    seal(&b);
    const auto parser = makeParser("nlink", {});
    std::vector<RangeReading> readings;
    feed(parser.get(), b + Bytes(4096, '\0'), &readings);
    EXPECT_TRUE(parser->takeData().empty()) << at;
    EXPECT_GE(parser->counters().corrupt, 1) << at;
    EXPECT_LE(parser->buffered(), 4096u);
  }
}

}  // namespace
}  // namespace vir::uwb::test
