#include "vir/team/peer_message.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace vir::team {
namespace {

constexpr std::uint8_t kMagic = 0xA7, kVersion = 1, kHasAnchor = 1;
constexpr double kPositionUnit = 1e-4;   // [m]
constexpr double kFarthest = 2e5;        // [m]
constexpr double kSmallestSigma = 1e-4;  // [m], code 1
constexpr double kStepsPerOctave = 13;   // of a standard deviation
constexpr double kCorrelationUnit = 0.01;
constexpr int kMaxCorrelation = 99;

class Writer {
 public:
  explicit Writer(PeerPacket* packet) : packet_(packet) {}
  void put(std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) {
      (*packet_)[at_++] = static_cast<std::uint8_t>(value >> (8 * i));
    }
  }
  std::size_t at() const { return at_; }

 private:
  PeerPacket* packet_;
  std::size_t at_ = 0;
};

class Reader {
 public:
  explicit Reader(const std::uint8_t* bytes) : bytes_(bytes) {}
  std::uint64_t take(int bytes) {
    std::uint64_t value = 0;
    for (int i = 0; i < bytes; ++i) value |= static_cast<std::uint64_t>(bytes_[at_++]) << (8 * i);
    return value;
  }

 private:
  const std::uint8_t* bytes_;
  std::size_t at_ = 0;
};

/// CRC-32 of IEEE 802.3, bit by bit: sixty bytes need no table.
std::uint32_t crc32(const std::uint8_t* bytes, std::size_t size) {
  std::uint32_t crc = 0xFFFFFFFFu;
  for (std::size_t i = 0; i < size; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xEDB88320u & (0u - (crc & 1u)));
  }
  return ~crc;
}

void putPosition(const Vec3& p, Writer* w) {
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(p[i]) <= kFarthest)) {
      throw std::invalid_argument("a peer message carries positions up to 200 km only, not " +
                                  std::to_string(p[i]) + " m");
    }
    w->put(
        static_cast<std::uint32_t>(static_cast<std::int32_t>(std::llround(p[i] / kPositionUnit))),
        4);
  }
}

Vec3 takePosition(Reader* r) {
  Vec3 p;
  for (int i = 0; i < 3; ++i) {
    p[i] = kPositionUnit * static_cast<std::int32_t>(static_cast<std::uint32_t>(r->take(4)));
  }
  return p;
}

/// 0: exactly known; else the next larger of the steps.
std::uint8_t sigmaCode(double variance) {
  if (!std::isfinite(variance) || variance < 0) {
    throw std::invalid_argument("a peer message needs finite variances of 0 or more, not " +
                                std::to_string(variance));
  }
  if (variance == 0) return 0;
  const double steps = kStepsPerOctave * std::log2(std::sqrt(variance) / kSmallestSigma);
  // A value that was decoded before must get its old code in spite of rounding.
  return static_cast<std::uint8_t>(1 + std::clamp(std::ceil(steps - 1e-6), 0.0, 254.0));
}

double sigmaOf(std::uint8_t code) {
  return code == 0 ? 0 : kSmallestSigma * std::exp2((code - 1) / kStepsPerOctave);
}

void putCovariance(const Mat3& C, Writer* w) {
  for (int i = 0; i < 3; ++i) w->put(sigmaCode(C(i, i)), 1);
  for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
    const double scale = std::sqrt(C(i, i) * C(j, j));
    const double rho = scale > 0 ? 0.5 * (C(i, j) + C(j, i)) / scale : 0;
    if (!std::isfinite(rho)) throw std::invalid_argument("a peer message needs finite covariances");
    const int code = static_cast<int>(std::clamp(std::round(rho / kCorrelationUnit),
                                                 -1.0 * kMaxCorrelation, 1.0 * kMaxCorrelation));
    w->put(static_cast<std::uint8_t>(static_cast<std::int8_t>(code)), 1);
  }
}

/// False if the bytes are no covariance.
bool takeCovariance(Reader* r, Mat3* C) {
  Vec3 sigma;
  for (int i = 0; i < 3; ++i) sigma[i] = sigmaOf(static_cast<std::uint8_t>(r->take(1)));
  Mat3 rho = Mat3::Identity();
  for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
    const int code = static_cast<std::int8_t>(static_cast<std::uint8_t>(r->take(1)));
    if (std::abs(code) > kMaxCorrelation) return false;
    rho(i, j) = rho(j, i) = kCorrelationUnit * code;
  }
  // Rounding may have made it slightly indefinite; more than that nobody has sent.
  const double lowest =
      Eigen::SelfAdjointEigenSolver<Mat3>(rho, Eigen::EigenvaluesOnly).eigenvalues()[0];
  if (lowest < -3 * kCorrelationUnit) return false;
  if (lowest < 1e-6) {
    const double shrink = 1 / (1 + 1e-6 - lowest);
    rho = shrink * rho + (1 - shrink) * Mat3::Identity();
  }
  *C = sigma.asDiagonal() * rho * sigma.asDiagonal();
  return true;
}

}  // namespace

PeerPacket encode(const PeerMessage& m) {
  PeerPacket packet{};
  Writer w(&packet);
  w.put(kMagic, 1);
  w.put(kVersion, 1);
  w.put(m.anchor ? kHasAnchor : 0, 1);
  w.put(0, 1);
  w.put(m.robot, 2);
  w.put(m.segment, 2);
  w.put(m.sequence, 2);
  const PeerAnchor anchor = m.anchor.value_or(PeerAnchor());
  w.put(anchor.id, 2);
  w.put(static_cast<std::uint64_t>(m.t), 8);
  putPosition(m.p_W, &w);
  putPosition(anchor.p_W, &w);
  putCovariance(m.covariance, &w);
  putCovariance(anchor.covariance, &w);
  w.put(crc32(packet.data(), w.at()), 4);
  static_assert(1 + 1 + 1 + 1 + 2 + 2 + 2 + 2 + 8 + 12 + 12 + 6 + 6 + 4 == kPeerMessageBytes);
  return packet;
}

const char* name(PeerDecoding decoding) {
  switch (decoding) {
    case PeerDecoding::ok:
      return "ok";
    case PeerDecoding::wrong_size:
      return "wrong_size";
    case PeerDecoding::not_ours:
      return "not_ours";
    case PeerDecoding::unknown_version:
      return "unknown_version";
    case PeerDecoding::bad_checksum:
      return "bad_checksum";
    case PeerDecoding::bad_content:
      break;
  }
  return "bad_content";
}

PeerDecoding decode(const std::uint8_t* bytes, std::size_t size, PeerMessage* message) {
  if (bytes == nullptr || size != kPeerMessageBytes) return PeerDecoding::wrong_size;
  Reader r(bytes);
  if (r.take(1) != kMagic) return PeerDecoding::not_ours;
  if (r.take(1) != kVersion) return PeerDecoding::unknown_version;
  Reader checksum(bytes + kPeerMessageBytes - 4);
  if (checksum.take(4) != crc32(bytes, kPeerMessageBytes - 4)) return PeerDecoding::bad_checksum;
  const std::uint64_t flags = r.take(1);
  if (flags > kHasAnchor || r.take(1) != 0) return PeerDecoding::bad_content;
  PeerMessage m;
  m.robot = static_cast<std::uint16_t>(r.take(2));
  m.segment = static_cast<std::uint16_t>(r.take(2));
  m.sequence = static_cast<std::uint16_t>(r.take(2));
  PeerAnchor anchor;
  anchor.id = static_cast<std::uint16_t>(r.take(2));
  m.t = static_cast<TimeNs>(r.take(8));
  m.p_W = takePosition(&r);
  anchor.p_W = takePosition(&r);
  if (!takeCovariance(&r, &m.covariance) || !takeCovariance(&r, &anchor.covariance)) {
    return PeerDecoding::bad_content;
  }
  if (flags == kHasAnchor) m.anchor = anchor;
  *message = m;
  return PeerDecoding::ok;
}

}  // namespace vir::team
