/// Each protocol: good streams, in any pieces; damaged ones; failed measurements.
#include <gtest/gtest.h>

#include "auto_parser.h"
#include "uwb_streams.h"

namespace vir::uwb::test {
namespace {

void expectSame(const Parsed& a, const Parsed& b) {
  ASSERT_EQ(a.readings.size(), b.readings.size());
  for (std::size_t i = 0; i < a.readings.size(); ++i) {
    EXPECT_EQ(a.readings[i].responder, b.readings[i].responder);
    EXPECT_EQ(a.readings[i].range_m, b.readings[i].range_m);
    EXPECT_EQ(a.readings[i].device_time, b.readings[i].device_time);
  }
  EXPECT_EQ(a.counters.messages, b.counters.messages);
  EXPECT_EQ(a.counters.failed, b.counters.failed);
  EXPECT_EQ(a.counters.corrupt, b.counters.corrupt);
  EXPECT_EQ(a.counters.other_text, b.counters.other_text);
  EXPECT_EQ(a.counters.skipped_bytes, b.counters.skipped_bytes);
  EXPECT_EQ(a.buffered, b.buffered);
}

class EachProtocol : public ::testing::TestWithParam<Stream> {};

TEST_P(EachProtocol, GoodStreamGivesItsRanges) {
  const Parsed p = parse(GetParam().protocol, GetParam().bytes);
  EXPECT_EQ(shown(p.readings), GetParam().ranges);
  EXPECT_EQ(p.counters.corrupt, 0);
  EXPECT_EQ(p.counters.fragments, 0);
  EXPECT_EQ(p.counters.ranges, static_cast<long>(p.readings.size()));
  EXPECT_EQ(p.buffered, 0u);
}

TEST_P(EachProtocol, PiecesDoNotMatter) {
  const Bytes& bytes = GetParam().bytes;
  const Parsed whole = parse(GetParam().protocol, bytes);
  for (std::size_t piece : {1, 2, 3, 7, 64}) {
    expectSame(whole, parse(GetParam().protocol, bytes, piece));
  }
  for (std::size_t split = 1; split < bytes.size(); ++split) {
    const auto parser = makeParser(GetParam().protocol, {});
    Parsed p;
    feed(parser.get(), std::string_view(bytes).substr(0, split), &p.readings);
    feed(parser.get(), std::string_view(bytes).substr(split), &p.readings);
    p.counters = parser->counters();
    p.buffered = parser->buffered();
    expectSame(whole, p);
  }
}

TEST_P(EachProtocol, AutoRecognisesIt) {
  if (GetParam().protocol == "dwm1001_tlv") return;  // does not send unasked
  const std::string noise = "\xF8\x80\x00garbage before the first line\r\nmore of it";
  AutoParser parser({});
  std::vector<RangeReading> readings;
  feed(&parser, noise + "\r\n" + GetParam().bytes, &readings);
  EXPECT_EQ(parser.name(), GetParam().protocol);
  EXPECT_EQ(shown(readings), GetParam().ranges);
}

TEST_P(EachProtocol, ResetForgetsTheMessageBegun) {
  const auto parser = makeParser(GetParam().protocol, {});
  std::vector<RangeReading> readings;
  const Bytes& bytes = GetParam().bytes;
  feed(parser.get(), std::string_view(bytes).substr(0, 11), &readings);
  parser->reset();
  EXPECT_EQ(parser->buffered(), 0u);
  readings.clear();
  feed(parser.get(), bytes, &readings);
  EXPECT_EQ(shown(readings), GetParam().ranges);
}

/// Whatever byte is lost or flipped: never a range that no good message holds, unless the damage
/// leaves a message that is right in itself (digits of a text without a checksum).
TEST_P(EachProtocol, LostBytesAreNoticed) {
  const Bytes& bytes = GetParam().bytes;
  const Parsed good = parse(GetParam().protocol, bytes);
  for (std::size_t lost = 0; lost < bytes.size(); ++lost) {
    Bytes damaged = bytes;
    damaged.erase(lost, 1);
    const Parsed p = parse(GetParam().protocol, damaged + bytes);
    // The second copy comes through, but for a message that the damage swallowed.
    EXPECT_GE(p.counters.messages, good.counters.messages - 1) << "byte " << lost;
    EXPECT_LE(p.counters.messages, 2 * good.counters.messages) << "byte " << lost;
  }
}

INSTANTIATE_TEST_SUITE_P(Uwb, EachProtocol, ::testing::ValuesIn(goodStreams()),
                         [](const auto& i) { return i.param.protocol; });

TEST(Dwm1001, MixedUpLineIsRefused) {
  const Parsed p =
      parse("dwm1001",
            "\r\nx\r\n"
            "DIST,4,AN0,022E,7.94,8.03,0.00,3.44,AN1,1234,0.00,8.00,0.00,2.12,AN2,"
            "0F0F,1.00,1.00,1.00,1.00,AN3,15BA,0.00,0,AN3,15BA,0.00,0.00,0.00,0.00\r\n");
  EXPECT_TRUE(p.readings.empty());
  EXPECT_EQ(p.counters.corrupt, 1);
}

TEST(Dwm1001, DamagedLinesAreRefused) {
  for (const char* line :
       {"DIST,2,AN0,022E,7.94,8.03,0.00,3.44\r\n",   // one anchor missing
        "DIST,1,AN0,022E,7.94,8.03,0.00,3.4\r\n",    // a digit lost
        "DIST,1,AN0,022E,7.94,8.03,0.00,-3.44\r\n",  // negative
        "DIST,1,AN0,22E,7.94,8.03,0.00,3.44\r\n",    // id too short
        "DIST,1,AN0,022E,7.94,8.03,0.00,3.44,POS,1.00,2.00,3.00,101\r\n",
        "DIST,1,AN0,022E,7.94,8.03,0.00,3.44 trailing\r\n",
        "DIST,2,AN0,022E,7.94,8.03,0.00,3.44,AN1,022E,0.00,0.00,0.00,3.00\r\n",  // id twice
        "DIST,1,AN0,022E,nan,8.03,0.00,3.44\r\n", "022E[7.94,8.03,0.00]=3.38 15BA[0.00,8.0\r\n"}) {
    const Parsed p = parse("dwm1001", std::string("x\r\n") + line);
    EXPECT_TRUE(p.readings.empty()) << line;
    EXPECT_EQ(p.counters.corrupt, 1) << line;
  }
}

TEST(Dwm1001, ZeroIsAFailedMeasurement) {
  const Parsed p = parse("dwm1001", "DIST,1,AN0,022E,7.94,8.03,0.00,0.00\r\n");
  EXPECT_TRUE(p.readings.empty());
  EXPECT_EQ(p.counters.failed, 1);
  EXPECT_EQ(p.counters.corrupt, 0);
}

TEST(Trek1000, MaskedRangesFail) {
  const Parsed p =
      parse("trek1000", "mc 05 00000663 000005a3 00000512 ffffffff 095f c1 00024bed t7:0\r\n");
  EXPECT_EQ(shown(p.readings), "0=1.635 2=1.298 ");
  EXPECT_EQ(p.counters.failed, 2);
  EXPECT_EQ(p.readings[0].own, 7);
  EXPECT_EQ(p.readings[0].device_time, 0x24bedLL * 1000000);
}

TEST(Trek1000, EightRangesAndRssi) {
  const Parsed p = parse("trek1000",
                         "mc 81 00000663 00000000 00000000 00000000 00000000 00000000 00000000 "
                         "00000512 095f c1 00024bed t7:0 1eef\r\n");
  EXPECT_EQ(shown(p.readings), "0=1.635 7=1.298 ");
  EXPECT_NEAR(p.readings[0].rssi_dbm.value(), -79.19, 1e-9);
}

TEST(Trek1000, NegativeAndFarRangesAreImplausible) {
  const Parsed p =
      parse("trek1000", "mc 03 fffffe00 0044aa20 00000000 00000000 095f c1 00024bed t7:0\r\n");
  EXPECT_TRUE(p.readings.empty());
  EXPECT_EQ(p.counters.implausible, 2);
}

TEST(Trek1000, DamagedLinesAreRefused) {
  for (const char* line : {"mc 0f 00000663 000005a3 00000512 000004cb 095f c1 00024bed\n",
                           "mc 0f 0000663 000005a3 00000512 000004cb 095f c1 00024bed a0:0\n",
                           "mc 1f 00000663 000005a3 00000512 000004cb 095f c1 00024bed a0:0\n",
                           "mc 0f 00000663 000005a3 00000512 095f c1 00024bed a0:0\n",
                           "mc 0f 00000663 000005a3 00000512 000004cb 095f c1 00024bed a0:0 1\n",
                           "mc 0f 00000663 0000mc 0f 00000663 000005a3 00000512 000004cb 095f c1 "
                           "00024bed a0:0\n"}) {
    const Parsed p = parse("trek1000", std::string("x\n") + line);
    EXPECT_TRUE(p.readings.empty()) << line;
    EXPECT_EQ(p.counters.corrupt, 1) << line;
  }
}

TEST(AtRange, AnchorsAndFailures) {
  const Parsed p =
      parse("at_range",
            "AT+RANGE=tid:2,mask:07,seq:1,range:(92,0,150,7),rssi:(-79.31,0.0,-80.5,0),"
            "kx:1.2,ky:-0.4,ancid:(3,1,-1,0)\r\n");
  EXPECT_EQ(shown(p.readings), "3=0.920 ");
  EXPECT_EQ(p.counters.failed, 3);  // zero, no anchor, not in the mask
  EXPECT_EQ(p.readings[0].own, 2);
  EXPECT_DOUBLE_EQ(p.readings[0].rssi_dbm.value(), -79.31);
}

TEST(AtRange, DamagedLinesAreRefused) {
  for (const char* line : {"AT+RANGE=tid:0,mask:01,seq:65,range:(92,0,0,0,0,0,0)\n",
                           "AT+RANGE=tid:0,mask:01,seq:65,range:(92,0,0,0\n",
                           "AT+RANGE=tid:0,mask:1F,seq:65,range:(92,0,0,0)\n",
                           "AT+RANGE=tid:0,mask:01,seq:65,range:(92,0,0,0),ancid:(1,2,3)\n",
                           "AT+RANGE=tid:0,mask:01,range:(92,0,0,0)\n",
                           "RANGE=tid:0,mask:01,seq:65,range:(92,0,0,0)\n",
                           "AT+RANGE=tid:0,mask:01,seq:65,range:(92,0,0,0),\n"}) {
    const Parsed p = parse("at_range", std::string("x\n") + line);
    EXPECT_TRUE(p.readings.empty()) << line;
    EXPECT_EQ(p.counters.corrupt, 1) << line;
  }
}

TEST(Qm33, BlocksMustBeComplete) {
  const std::string head =
      "SESSION_INFO_NTF: {session_handle=1, sequence_number=1, block_index=1, n_measurements=";
  const std::string good = "[mac_address=0x0001, status=\"SUCCESS\", distance[cm]=245]";
  for (const std::string& block :
       {head + "2 " + good + "}\n", head + "1 " + good + ";" + good + "}\n",
        head + "1 [mac_address=0x0001, status=\"SUCCESS\"]}\n",
        head + "1 [mac_address=0x0001, distance[cm]=245]}\n", head + "1 " + good + "} more\n",
        head + "1 [mac_address=0x0001, status=\"SUCC}\n"}) {
    const Parsed p = parse("qm33", "x\n" + block);
    EXPECT_TRUE(p.readings.empty()) << block;
    EXPECT_EQ(p.counters.corrupt, 1) << block;
  }
  // One without an end does not take the next with it.
  const Parsed p = parse("qm33", "x\n" + head + "2 " + good + ";\n" + head + "1 " + good + "}\n");
  EXPECT_EQ(shown(p.readings), "1=2.450 ");
  EXPECT_EQ(p.counters.corrupt, 1);
}

TEST(Qm33, EndlessBlockIsDropped) {
  std::string text = "x\nSESSION_INFO_NTF: {session_handle=1\n";
  for (int i = 0; i < 2000; ++i) text += "and so on and so on\n";
  const Parsed p = parse("qm33", text);
  EXPECT_GE(p.counters.corrupt, 1);
  EXPECT_LE(p.buffered, 8192u);
}

TEST(Nlink, FieldsAreRead) {
  const Parsed p = parse("nlink", nodeFrame3({{1, 2345}}, 4000000000U));
  ASSERT_EQ(p.readings.size(), 1u);
  EXPECT_EQ(p.readings[0].own, 9);
  EXPECT_EQ(p.readings[0].device_time, 4000000000LL * 1000000);
  EXPECT_DOUBLE_EQ(p.readings[0].fp_rssi_dbm.value(), -80);
  EXPECT_DOUBLE_EQ(p.readings[0].rssi_dbm.value(), -78);
  EXPECT_TRUE(p.readings[0].line_of_sight.value());
  EXPECT_FALSE(parse("nlink", nodeFrame2({{1, 2345}})).readings[0].line_of_sight.value());
  EXPECT_EQ(parse("nlink", tagFrame0({1000})).counters.failed, 7);
  EXPECT_EQ(parse("nlink", nodeFrame3({{1, -5}})).counters.implausible, 1);
}

TEST(Nlink, EveryFlippedBitIsNoticed) {
  for (const Bytes& frame : {nodeFrame3({{1, 2345}, {2, 6789}}), nodeFrame2({{3, 1500}}),
                             nodeFrame5(70000, 4321), tagFrame0({1000, 2000, 3000})}) {
    for (std::size_t bit = 0; bit < 8 * frame.size(); ++bit) {
      Bytes damaged = frame;
      damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
      EXPECT_TRUE(parse("nlink", damaged).readings.empty()) << "bit " << bit;
    }
  }
}

TEST(Nlink, DamagedLengthDoesNotSwallowTheNextFrames) {
  Bytes damaged = nodeFrame3({{1, 2345}});
  damaged[2] = damaged[3] = '\xFF';
  const Parsed p = parse("nlink", damaged + nodeFrame3({{2, 1111}}));
  EXPECT_EQ(shown(p.readings), "2=1.111 ");
  EXPECT_GE(p.counters.corrupt, 1);
}

TEST(Dwm1001Tlv, ErrorsAndDamage) {
  EXPECT_EQ(parse("dwm1001_tlv", Bytes("\x40\x01\x04", 3)).counters.device_errors, 1);
  Bytes wrong_count = tlvAnswer({{1, 1000}});
  wrong_count[20] = 2;
  EXPECT_TRUE(parse("dwm1001_tlv", wrong_count).readings.empty());
  EXPECT_TRUE(parse("dwm1001_tlv", tlvAnswer({{1, 1000}, {1, 2000}})).readings.empty());
  EXPECT_EQ(parse("dwm1001_tlv", tlvAnswer({{1, 0}})).counters.failed, 1);
}

TEST(Arduino, DamagedLinesAreRefused) {
  for (const char* line : {"from: 0xE29C\tRange: 1.484 m\tRX power: -67.19 d\n",
                           "from: 0xE29C\tRange: 1484 m\tRX power: -67.19 dBm\n",
                           "from: 0xE29C\tRange: 1.484 m\tRX powefrom: 0xE29C\n",
                           "from: 0xE29C1\tRange: 1.484 m\tRX power: -67.19 dBm\n",
                           "from: 0xE29C\tRange: inf m\tRX power: -67.19 dBm\n"}) {
    const Parsed p = parse("dw1000_arduino", std::string("x\n") + line);
    EXPECT_TRUE(p.readings.empty()) << line;
    EXPECT_EQ(p.counters.corrupt, 1) << line;
  }
}

TEST(Json, DamagedLinesAreRefused) {
  for (const char* line :
       {"{\"uid\":1,\"ouid\":2,\"raz\":[1.5]\n", "{\"uid\":1,\"ouid\":-2,\"raz\":[1.5]}\n",
        "{\"uid\":1,\"ouid\":2,\"raz\":[1.5],\"raz\":[2.5]}\n",
        "{\"uid\":1,\"ouid\":\"2\",\"raz\":[1.5]}\n", "{\"uid\":1,\"ouid\":2,\"raz\":1.5}\n",
        "\"ouid\":2,\"raz\":[1.5]}\n", "{\"ouid\":2,\"raz\":[1.5],\"utime\":1.5}\n"}) {
    const Parsed p = parse("json", std::string("x\n") + line);
    EXPECT_TRUE(p.readings.empty()) << line;
    EXPECT_EQ(p.counters.corrupt, 1) << line;
  }
  EXPECT_EQ(parse("json", "{\"uid\":1,\"ouid\":2,\"raz\":[null]}\n").counters.failed, 1);
  EXPECT_EQ(parse("json", "{\"uid\":1}\n").counters.ignored, 1);
}

TEST(Auto, ChangesItsMindWhenAnotherDeviceComes) {
  const auto streams = goodStreams();
  AutoParser parser({});
  std::vector<RangeReading> readings;
  feed(&parser, streams[2].bytes, &readings);
  ASSERT_EQ(parser.name(), "trek1000");
  for (int i = 0; i < 200; ++i) feed(&parser, streams[0].bytes, &readings);
  EXPECT_EQ(parser.name(), "dwm1001");
  EXPECT_GT(parser.counters().messages, 300);
}

TEST(Limits, AreSettings) {
  const RangeLimits limits{1.5, 2.0};
  EXPECT_EQ(shown(parse("qm33", goodStreams()[4].bytes, 0, limits).readings), "");
  const Parsed p =
      parse("nlink", nodeFrame3({{1, 1499}, {2, 1500}, {3, 2000}, {4, 2001}}), 0, limits);
  EXPECT_EQ(shown(p.readings), "2=1.500 3=2.000 ");
  EXPECT_EQ(p.counters.implausible, 2);
}

}  // namespace
}  // namespace vir::uwb::test
