/// Each IMU protocol: what the emulator's encoders write comes back, in any pieces; damage is
/// noticed.
#include <gtest/gtest.h>

#include <cmath>

#include "imu_options.h"
#include "imu_parser.h"
#include "mavlink_parser.h"
#include "messages.h"
#include "vir/core/random.h"

namespace vir::serial_imu {
namespace {

using emulator::ImuMessage;

constexpr std::size_t kLongestHeld = 300 + 1024;

void feed(ImuParser* parser, std::string_view bytes, std::vector<ImuReading>* out) {
  parser->feed(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), out);
}

struct Parsed {
  std::vector<ImuReading> readings;
  ParserCounters counters;
};

Parsed parse(const std::string& protocol, std::string_view bytes, std::size_t piece = 0,
             const MavlinkOptions& mavlink = {}) {
  const auto parser = makeParser(protocol, {}, mavlink);
  Parsed p;
  if (piece == 0) piece = bytes.size();
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    feed(parser.get(), bytes.substr(at, piece), &p.readings);
  }
  p.counters = parser->counters();
  return p;
}

ImuMessage message(int i) {
  ImuMessage m;
  m.device_time = 1'000'000'000LL * 4000 + 5'000'000LL * i;
  m.sequence = static_cast<unsigned>(i);
  m.acc_m_s2 = {0.1 * i, -0.2, 9.806};
  m.gyro_rad_s = {0.01, -0.02 * i, 0.003};
  return m;
}

struct Protocol {
  const char* encoder;
  const char* parser;
  double acc_step, gyro_step;  ///< of the format
  TimeNs time_step;
};

const Protocol kProtocols[] = {{"text", "text", 1e-6, 1e-7, 1000},
                               {"binary", "binary", 1e-6, 1e-7, 1000},
                               {"mavlink", "mavlink", 1e-6, 1e-7, 1000},
                               {"mavlink_scaled", "mavlink", 0.0098, 1e-3, 1000000}};

std::string stream(const Protocol& p, int n) {
  std::string bytes;
  for (int i = 0; i < n; ++i) bytes += emulator::imuEncoder(p.encoder)(message(i));
  return bytes;
}

class EachImu : public ::testing::TestWithParam<Protocol> {};

TEST_P(EachImu, RoundTrip) {
  const Protocol& p = GetParam();
  const std::string bytes = stream(p, 20);
  const TimeNs wrap = p.time_step == 1000 && std::string(p.parser) != "mavlink"
                          ? (TimeNs{1} << 32) * 1000
                          : INT64_MAX;
  for (std::size_t piece : {0, 1, 3, 17}) {
    const Parsed parsed = parse(p.parser, bytes, piece);
    ASSERT_EQ(parsed.readings.size(), 20u);
    EXPECT_EQ(parsed.counters.skipped_bytes, 0u);
    EXPECT_EQ(parsed.counters.lost, 0);
    for (int i = 0; i < 20; ++i) {
      const ImuReading& r = parsed.readings[static_cast<std::size_t>(i)];
      const ImuMessage m = message(i);
      EXPECT_EQ(r.device_time, m.device_time % wrap / p.time_step * p.time_step);
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_NEAR(r.acc_m_s2[k], m.acc_m_s2[k], p.acc_step);
        EXPECT_NEAR(r.gyro_rad_s[k], m.gyro_rad_s[k], p.gyro_step);
      }
    }
  }
}

TEST_P(EachImu, EverySplitPoint) {
  const std::string bytes = stream(GetParam(), 3);
  for (std::size_t split = 1; split < bytes.size(); ++split) {
    const auto parser = makeParser(GetParam().parser, {}, {});
    std::vector<ImuReading> readings;
    feed(parser.get(), std::string_view(bytes).substr(0, split), &readings);
    feed(parser.get(), std::string_view(bytes).substr(split), &readings);
    EXPECT_EQ(readings.size(), 3u) << split;
    EXPECT_EQ(parser->buffered(), 0u);
  }
}

TEST_P(EachImu, EveryFlippedBitIsNoticed) {
  const std::string good = stream(GetParam(), 1);
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::string damaged = "\r\n" + good;
    damaged[2 + bit / 8] = static_cast<char>(damaged[2 + bit / 8] ^ (1 << (bit % 8)));
    const Parsed p = parse(GetParam().parser, damaged + good);
    ASSERT_LE(p.readings.size(), 2u);
    for (const ImuReading& r : p.readings) {
      // Only what is no part of the message may change: the line's end, a digit's case.
      EXPECT_EQ(r.acc_m_s2, parse(GetParam().parser, good).readings[0].acc_m_s2) << bit;
      EXPECT_EQ(r.device_time, parse(GetParam().parser, good).readings[0].device_time) << bit;
    }
  }
}

TEST_P(EachImu, NoiseGivesNothingAndHoldsLittle) {
  Random random(4);
  const auto parser = makeParser(GetParam().parser, {}, {});
  std::vector<ImuReading> readings;
  for (int i = 0; i < 4096; ++i) {
    std::string piece(256, 0);
    for (char& c : piece) c = static_cast<char>(static_cast<int>(random.uniform(0, 256)));
    feed(parser.get(), piece, &readings);
    ASSERT_LE(parser->buffered(), kLongestHeld);
  }
  EXPECT_TRUE(readings.empty());
  // And it still understands what comes then.
  feed(parser.get(), "\r\n" + stream(GetParam(), 20), &readings);
  EXPECT_GE(readings.size(), 15u);
}

TEST_P(EachImu, DamagedStream) {
  Random random(5);
  const std::string good = stream(GetParam(), 10);
  const auto parser = makeParser(GetParam().parser, {}, {});
  std::vector<ImuReading> readings;
  int sent = 0;
  for (int i = 0; i < 1000; ++i, sent += 10) {
    std::string copy = good;
    for (int hits = static_cast<int>(random.uniform(0, 4)); hits > 0; --hits) {
      const auto at = static_cast<std::size_t>(random.uniform(0, static_cast<double>(copy.size())));
      if (hits == 1) copy.erase(at, 1);
      if (hits != 1) copy[at] = static_cast<char>(static_cast<int>(random.uniform(0, 256)));
    }
    feed(parser.get(), copy, &readings);
    ASSERT_LE(parser->buffered(), kLongestHeld);
  }
  EXPECT_GT(static_cast<int>(readings.size()), sent / 2);
  EXPECT_LE(static_cast<int>(readings.size()), sent);
  for (const ImuReading& r : readings) {
    ASSERT_NEAR(r.acc_m_s2[2], 9.806, GetParam().acc_step);
    ASSERT_NEAR(r.gyro_rad_s[0], 0.01, GetParam().gyro_step);
  }
}

INSTANTIATE_TEST_SUITE_P(SerialImu, EachImu, ::testing::ValuesIn(kProtocols),
                         [](const auto& i) { return std::string(i.param.encoder); });

/// The example of the documentation, written by hand.
TEST(ImuText, DocumentedLine) {
  const Parsed p = parse("text", "boot\r\nIMU,1234567,0.012,-0.034,9.806,0.001,0.002,-3e-3*2B\r\n");
  ASSERT_EQ(p.readings.size(), 1u);
  EXPECT_EQ(p.readings[0].device_time, 1234567000);
  EXPECT_DOUBLE_EQ(p.readings[0].acc_m_s2[1], -0.034);
  EXPECT_DOUBLE_EQ(p.readings[0].gyro_rad_s[2], -0.003);
  EXPECT_EQ(p.counters.other_text, 1);
}

TEST(ImuText, WhatIsNoNumberIsRefused) {
  for (const char* body : {"IMU,1,nan,0,0,0,0,0", "IMU,1,0,0,0,0,0", "IMU,-1,0,0,0,0,0,0",
                           "IMU,1,0,0,0,0,0,0,0", "IMU,4294967296,0,0,0,0,0,0"}) {
    unsigned sum = 0;
    for (const char* c = body; *c != 0; ++c) sum ^= static_cast<unsigned char>(*c);
    char line[100];
    std::snprintf(line, sizeof line, "x\n%s*%02X\n", body, sum);
    const Parsed p = parse("text", line);
    EXPECT_TRUE(p.readings.empty()) << body;
    EXPECT_EQ(p.counters.corrupt, 1) << body;
  }
}

TEST(ImuBinary, LostFramesAreCounted) {
  std::string bytes;
  for (int i : {250, 251, 254, 255, 256, 260}) bytes += emulator::encodeImuBinary(message(i));
  const Parsed p = parse("binary", bytes);
  EXPECT_EQ(p.readings.size(), 6u);
  EXPECT_EQ(p.counters.lost, 2 + 3);
}

TEST(ImuLimits, ImplausibleReadingsAreCounted) {
  ImuMessage m = message(1);
  m.acc_m_s2[0] = 1e5;
  EXPECT_EQ(parse("binary", emulator::encodeImuBinary(m)).counters.implausible, 1);
  m.acc_m_s2[0] = std::nan("");
  EXPECT_EQ(parse("binary", emulator::encodeImuBinary(m)).counters.implausible, 1);
}

/// A frame put together by hand, byte by byte, with the CRC computed elsewhere: the CRC of
/// MAVLink's check string and a message of 1 byte is what the specification says.
TEST(Mavlink, VersionOneAndSignedFrames) {
  const std::string v2 = emulator::encodeMavlinkHighres(message(3));
  // Signed: flag set, so the CRC changes, 13 bytes follow.
  const auto crcOf = [](const std::string& frame, std::size_t end, std::uint8_t extra) {
    unsigned crc = 0xFFFF;
    const auto add = [&crc](unsigned byte) {
      unsigned t = byte ^ (crc & 0xFF);
      t = (t ^ (t << 4)) & 0xFF;
      crc = (crc >> 8) ^ (t << 8) ^ (t << 3) ^ (t >> 4);
    };
    for (std::size_t i = 1; i < end; ++i) add(static_cast<unsigned char>(frame[i]));
    add(extra);
    return crc;
  };
  std::string signed_frame = v2.substr(0, v2.size() - 2);
  signed_frame[2] = 1;
  unsigned crc = crcOf(signed_frame, signed_frame.size(), 93);
  signed_frame += static_cast<char>(crc);
  signed_frame += static_cast<char>(crc >> 8);
  signed_frame += std::string(13, '\xFD');
  EXPECT_EQ(parse("mavlink", signed_frame + v2).readings.size(), 2u);

  std::string payload = v2.substr(10, v2.size() - 12);
  payload.resize(62, '\0');
  std::string v1 = std::string("\xFE\x3E\x07\x01\x01\x69", 6) + payload;
  crc = crcOf(v1, v1.size(), 93);
  v1 += static_cast<char>(crc);
  v1 += static_cast<char>(crc >> 8);
  const Parsed p = parse("mavlink", v1 + v2);
  ASSERT_EQ(p.readings.size(), 2u);
  EXPECT_EQ(p.readings[0].acc_m_s2, p.readings[1].acc_m_s2);
}

TEST(Mavlink, ZerosCutOffAreZeros) {
  ImuMessage m;
  m.device_time = 1000;
  const std::string frame = emulator::encodeMavlinkScaled(m);
  // 1 us is 0 ms: a payload of nothing but zeros keeps one byte.
  EXPECT_EQ(frame.size(), 13u);
  const Parsed p = parse("mavlink", frame);
  ASSERT_EQ(p.readings.size(), 1u);
  EXPECT_EQ(p.readings[0].device_time, 0);
  EXPECT_EQ(p.readings[0].acc_m_s2[2], 0);
}

TEST(Mavlink, OneSourceOfReadings) {
  const std::string highres = emulator::encodeMavlinkHighres(message(1));
  const std::string scaled = emulator::encodeMavlinkScaled(message(1));
  EXPECT_EQ(parse("mavlink", scaled + highres + scaled + highres).readings.size(), 3u);
  MavlinkOptions o;
  o.message = "scaled";
  EXPECT_EQ(parse("mavlink", scaled + highres + scaled + highres, 0, o).readings.size(), 2u);
  o.message = "highres";
  EXPECT_EQ(parse("mavlink", scaled + highres + scaled, 0, o).readings.size(), 1u);
  o.message = "auto";
  o.system_id = 7;
  const Parsed other = parse("mavlink", highres, 0, o);
  EXPECT_TRUE(other.readings.empty());
  EXPECT_EQ(other.counters.ignored, 1);
}

}  // namespace
}  // namespace vir::serial_imu
