#include "vir/team/peer_message.h"

#include <Eigen/Eigenvalues>
//
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "vir_test_noise.h"

namespace vir::team {
namespace {

PeerMessage example(test::Noise* noise) {
  PeerMessage m;
  m.robot = 7;
  m.segment = 2;
  m.sequence = 65535;
  m.t = 1671300425309837600;
  const auto random = [&](double scale) {
    return Vec3(scale * noise->normal(), scale * noise->normal(), scale * noise->normal());
  };
  const auto covariance = [&](double scale) {
    Mat3 L;
    for (int i = 0; i < 9; ++i) L.data()[i] = scale * noise->normal();
    return Mat3(L * L.transpose());
  };
  m.p_W = random(30);
  m.covariance = covariance(0.1);
  PeerAnchor anchor;
  anchor.id = 3;
  anchor.p_W = random(30);
  anchor.covariance = covariance(1);
  m.anchor = anchor;
  return m;
}

PeerPacket resealed(PeerPacket packet) {
  // The CRC of a packet with content that encode() would never write, found by asking for it bit
  // by bit is slow; the polynomial again, written as a table of nibbles.
  static const std::uint32_t table[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac,
                                          0x76dc4190, 0x6b6b51f4, 0x4db26158, 0x5005713c,
                                          0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c,
                                          0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
  std::uint32_t crc = ~0u;
  for (std::size_t i = 0; i + 4 < packet.size(); ++i) {
    crc = table[(crc ^ packet[i]) & 15] ^ (crc >> 4);
    crc = table[(crc ^ (packet[i] >> 4)) & 15] ^ (crc >> 4);
  }
  crc = ~crc;
  for (std::size_t i = 0; i < 4; ++i) {
    packet[packet.size() - 4 + i] = static_cast<std::uint8_t>(crc >> (8 * i));
  }
  return packet;
}

TEST(PeerMessage, FitsAUwbPacket) { EXPECT_LE(sizeof(PeerPacket), 64u); }

TEST(PeerMessage, ComesBackWithinItsResolution) {
  test::Noise noise(1);
  for (int i = 0; i < 1000; ++i) {
    const PeerMessage m = example(&noise);
    const PeerPacket packet = encode(m);
    PeerMessage back;
    ASSERT_EQ(decode(packet.data(), packet.size(), &back), PeerDecoding::ok);
    EXPECT_EQ(back.robot, m.robot);
    EXPECT_EQ(back.segment, m.segment);
    EXPECT_EQ(back.sequence, m.sequence);
    EXPECT_EQ(back.t, m.t);
    EXPECT_NEAR((back.p_W - m.p_W).cwiseAbs().maxCoeff(), 0, 0.51e-4);
    ASSERT_TRUE(back.anchor.has_value());
    EXPECT_EQ(back.anchor->id, m.anchor->id);
    EXPECT_NEAR((back.anchor->p_W - m.anchor->p_W).cwiseAbs().maxCoeff(), 0, 0.51e-4);
    for (int k = 0; k < 3; ++k) {
      const double ratio = std::sqrt(back.covariance(k, k) / m.covariance(k, k));
      EXPECT_GE(ratio, 1 - 1e-6);
      EXPECT_LE(ratio, 1.056);
    }
    const Mat3 C = back.covariance;
    EXPECT_NEAR(C(0, 1) / std::sqrt(C(0, 0) * C(1, 1)),
                m.covariance(0, 1) / std::sqrt(m.covariance(0, 0) * m.covariance(1, 1)), 0.04);
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Mat3>(C).eigenvalues()[0], 0);
  }
}

TEST(PeerMessage, EncodingWhatWasDecodedChangesNothing) {
  test::Noise noise(2);
  for (int i = 0; i < 300; ++i) {
    const PeerPacket once = encode(example(&noise));
    PeerMessage back;
    ASSERT_EQ(decode(once.data(), once.size(), &back), PeerDecoding::ok);
    const PeerPacket twice = encode(back);
    PeerMessage again;
    ASSERT_EQ(decode(twice.data(), twice.size(), &again), PeerDecoding::ok);
    EXPECT_EQ(again.p_W, back.p_W);
    EXPECT_NEAR((again.covariance.diagonal() - back.covariance.diagonal()).norm(), 0, 1e-12);
  }
}

TEST(PeerMessage, LayoutIsFixed) {
  // Byte by byte: other programs read this.
  PeerMessage m;
  m.robot = 0x0102;
  m.segment = 3;
  m.sequence = 4;
  m.t = 5;
  m.p_W = Vec3(0.0001, -0.0001, 1);
  const PeerPacket p = encode(m);
  const std::vector<int> head = {0xA7, 1, 0, 0, 2, 1, 3, 0, 4,   0,   0,   0,   5,    0,    0, 0,
                                 0,    0, 0, 0, 1, 0, 0, 0, 255, 255, 255, 255, 0x10, 0x27, 0, 0};
  for (std::size_t i = 0; i < head.size(); ++i) EXPECT_EQ(p[i], head[i]) << i;
  EXPECT_EQ(resealed(p), p);
}

TEST(PeerMessage, WithoutAnAnchor) {
  PeerMessage m, back;
  const PeerPacket packet = encode(m);
  ASSERT_EQ(decode(packet.data(), packet.size(), &back), PeerDecoding::ok);
  EXPECT_FALSE(back.anchor.has_value());
  EXPECT_TRUE(back.covariance.isZero(0));
}

TEST(PeerMessage, EveryFlippedBitIsNoticed) {
  test::Noise noise(3);
  const PeerPacket packet = encode(example(&noise));
  for (std::size_t bit = 0; bit < 8 * packet.size(); ++bit) {
    PeerPacket broken = packet;
    broken[bit / 8] = static_cast<std::uint8_t>(broken[bit / 8] ^ (1u << (bit % 8)));
    PeerMessage m;
    EXPECT_NE(decode(broken.data(), broken.size(), &m), PeerDecoding::ok) << bit;
  }
}

TEST(PeerMessage, MalformedInputIsNamed) {
  test::Noise noise(4);
  const PeerPacket good = encode(example(&noise));
  PeerMessage m;
  m.robot = 99;
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_EQ(decode(good.data(), size, &m), PeerDecoding::wrong_size);
  }
  EXPECT_EQ(decode(nullptr, 60, &m), PeerDecoding::wrong_size);
  PeerPacket other = good;
  other[0] = 0;
  EXPECT_EQ(decode(other.data(), other.size(), &m), PeerDecoding::not_ours);
  other = good;
  other[1] = 2;
  EXPECT_EQ(decode(other.data(), other.size(), &m), PeerDecoding::unknown_version);
  other = good;
  other[30] ^= 1;
  EXPECT_EQ(decode(other.data(), other.size(), &m), PeerDecoding::bad_checksum);
  other = good;
  other[2] = 2;
  EXPECT_EQ(decode(resealed(other).data(), other.size(), &m), PeerDecoding::bad_content);
  other = good;
  other[47] = 120;  // a correlation above 1
  EXPECT_EQ(decode(resealed(other).data(), other.size(), &m), PeerDecoding::bad_content);
  other = good;
  other[47] = 99, other[48] = 99, other[49] = static_cast<std::uint8_t>(-99);
  EXPECT_EQ(decode(resealed(other).data(), other.size(), &m), PeerDecoding::bad_content);
  EXPECT_EQ(m.robot, 99) << "a refused packet must leave the message alone";
}

TEST(PeerMessage, RandomBytesNeverGiveWhatIsNoNumber) {
  test::Noise noise(5);
  int good = 0;
  for (int i = 0; i < 20000; ++i) {
    PeerPacket p;
    for (auto& byte : p) byte = static_cast<std::uint8_t>(256 * noise.uniform());
    p[0] = 0xA7, p[1] = 1, p[2] &= 1, p[3] = 0;
    PeerMessage m;
    const PeerPacket sealed = resealed(p);
    if (decode(sealed.data(), sealed.size(), &m) != PeerDecoding::ok) continue;
    ++good;
    ASSERT_TRUE(m.p_W.allFinite() && m.covariance.allFinite());
    ASSERT_GE(Eigen::SelfAdjointEigenSolver<Mat3>(m.covariance).eigenvalues()[0], -1e-9);
  }
  EXPECT_GT(good, 100);
}

TEST(PeerMessage, RefusesToSendNonsense) {
  PeerMessage m;
  m.p_W.x() = std::nan("");
  EXPECT_THROW(encode(m), std::invalid_argument);
  m.p_W.x() = 1e6;
  EXPECT_THROW(encode(m), std::invalid_argument);
  m.p_W.x() = 0;
  m.covariance(1, 1) = -1;
  EXPECT_THROW(encode(m), std::invalid_argument);
  m.covariance = Mat3::Identity();
  m.covariance(0, 1) = m.covariance(1, 0) = std::nan("");
  EXPECT_THROW(encode(m), std::invalid_argument);
}

}  // namespace
}  // namespace vir::team
