/// What the emulator's encoders write, the parsers read back.
#include <gtest/gtest.h>

#include <cmath>

#include "messages.h"
#include "uwb_streams.h"
#include "vir/core/random.h"

namespace vir::uwb::test {
namespace {

double stepOf(const std::string& protocol) {
  if (protocol == "dwm1001" || protocol == "at_range" || protocol == "qm33") return 0.01;
  return protocol == "json" ? 1e-6 : 0.001;
}

class RoundTrip : public ::testing::TestWithParam<std::string> {};

TEST_P(RoundTrip, RangesComeBack) {
  const std::string protocol = GetParam();
  const auto encode = emulator::rangeEncoder(protocol);
  ASSERT_NE(encode, nullptr);
  Random random(3);
  std::string bytes;
  std::vector<emulator::RangeItem> expected;
  for (unsigned i = 0; i < 300; ++i) {
    emulator::RangeMessage m;
    m.device_time = 7'000'000LL * i;
    m.own_id = 9;
    m.sequence = i;
    const int n = 1 + static_cast<int>(random.uniform(0, 4));
    for (int k = 0; k < n; ++k) {
      emulator::RangeItem item;
      item.id = k;  // an anchor comes once
      item.range_m = random.uniform(0.1, 80);
      m.items.push_back(item);
      expected.push_back(item);
    }
    bytes += encode(m);
  }
  for (std::size_t piece : {0, 1, 13, 1000}) {
    const Parsed p = parse(protocol, bytes, piece);
    EXPECT_EQ(p.counters.corrupt, 0);
    EXPECT_EQ(p.counters.skipped_bytes, 0u);
    ASSERT_EQ(p.readings.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(p.readings[i].responder, expected[i].id);
      EXPECT_NEAR(p.readings[i].range_m, expected[i].range_m, stepOf(protocol) / 2 * 1.0001);
      if (p.readings[i].own) {
        EXPECT_EQ(*p.readings[i].own, 9);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Uwb, RoundTrip, ::testing::ValuesIn(emulator::rangeProtocols()),
                         [](const auto& i) { return i.param; });

TEST(RoundTripOfAll, TheSameProtocolsOnBothSides) {
  EXPECT_EQ(emulator::rangeProtocols(), protocolNames());
}

TEST(RoundTripOfAll, DeviceTimesComeBack) {
  for (const char* protocol : {"trek1000", "nlink", "json"}) {
    emulator::RangeMessage m;
    m.device_time = 5'123'000'000;
    m.items = {{1, 2.5}};
    const Parsed p = parse(protocol, emulator::rangeEncoder(protocol)(m));
    ASSERT_EQ(p.readings.size(), 1u);
    EXPECT_EQ(p.readings[0].device_time, m.device_time) << protocol;
  }
}

}  // namespace
}  // namespace vir::uwb::test
