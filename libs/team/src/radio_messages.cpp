#include "vir/team/radio_messages.h"

#include <algorithm>
#include <stdexcept>

#include "vir/geometry/finite_pose.h"
#include "vir/geometry/so3.h"
#include "vir/team/robot_record.h"

namespace vir::team {
namespace {

constexpr std::size_t kMostRadios = 32;
constexpr double kLongestPause = 1;  // [s] between the pieces of a message
constexpr std::uint8_t kFirstByte = 0xA7;
constexpr TimeNs kLateBy = 1'000'000'000;

std::uint16_t segmentOf(std::uint32_t session, std::uint32_t world) {
  // Of a session that has used up its worlds another one goes on.
  const std::uint32_t whole = (session << kWorldBits) + world;
  return static_cast<std::uint16_t>(whole);
}

/// Of the antenna, from that of the body.
Mat3 antennaCovariance(const StateEstimate& e, const Vec3& p_B_U) {
  Eigen::Matrix<double, 3, 6> J;
  J << Mat3::Identity(), -(e.state.T_W_B.R() * hat(p_B_U));
  const Mat3 C = J * e.covariance * J.transpose();
  return 0.5 * (C + C.transpose());
}

}  // namespace

std::optional<PeerAnchor> RadioTeller::nextAnchor(const std::vector<Anchor>& anchors) {
  for (std::size_t tried = 0; tried < anchors.size(); ++tried) {
    const Anchor& a = anchors[anchor_++ % anchors.size()];
    const auto sent = believed(a);
    if (!sent || a.id > UINT16_MAX) continue;
    return PeerAnchor{static_cast<std::uint16_t>(a.id), sent->p_W, sent->covariance};
  }
  return std::nullopt;
}

std::optional<PeerPacket> RadioTeller::tell(const StateEstimate& e,
                                            const std::vector<Anchor>& anchors) {
  const TimeNs t = e.state.t;
  if (!e.valid || !isFinite(e.state.T_W_B) || !e.covariance.allFinite()) return std::nullopt;
  if (t < due_ && due_ - t < kLateBy) return std::nullopt;
  const auto period = fromSeconds(1 / rate_hz_);
  due_ = t - due_ < period ? due_ + period : t + period;
  if (segment_ && *segment_ != e.segment) ++worlds_;
  segment_ = e.segment;
  PeerMessage m;
  m.robot = robot_;
  m.segment = segmentOf(session_, worlds_);
  m.sequence = sequence_;
  m.t = t;
  m.p_W = e.state.T_W_B * p_B_U_;
  m.covariance = antennaCovariance(e, p_B_U_);
  m.anchor = nextAnchor(anchors);
  try {
    const PeerPacket packet = encode(m);
    ++sequence_;
    return packet;
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // too far off to be told
  }
}

RadioInbox::RadioInbox(std::optional<std::uint16_t> own_number, LogSink log)
    : inbox_(own_number.value_or(UINT32_MAX), std::move(log)) {}

std::vector<HeardReport> RadioInbox::add(std::int64_t sender, const std::uint8_t* bytes,
                                         std::size_t size, TimeNs now, double arrival_s) {
  std::vector<HeardReport> out;
  if (pieces_.count(sender) == 0 && pieces_.size() >= kMostRadios) {
    ++too_many_;
    return out;
  }
  Pieces& pieces = pieces_[sender];
  if (!pieces.bytes.empty() && arrival_s - pieces.last_s > kLongestPause) {
    ++damaged_;
    pieces.bytes.clear();
  }
  pieces.last_s = arrival_s;
  // Never more is held than half a message and what came with one frame.
  pieces.bytes.insert(pieces.bytes.end(), bytes, bytes + size);
  search(sender, &pieces, now, arrival_s, &out);
  return out;
}

void RadioInbox::drop(std::size_t count, Pieces* pieces) {
  pieces->bytes.erase(pieces->bytes.begin(),
                      pieces->bytes.begin() + static_cast<std::ptrdiff_t>(count));
}

void RadioInbox::search(std::int64_t sender, Pieces* pieces, TimeNs now, double arrival_s,
                        std::vector<HeardReport>* out) {
  std::vector<std::uint8_t>& bytes = pieces->bytes;
  for (;;) {
    const auto first = std::find(bytes.begin(), bytes.end(), kFirstByte);
    foreign_bytes_ += first - bytes.begin();
    drop(static_cast<std::size_t>(first - bytes.begin()), pieces);
    if (bytes.size() < kPeerMessageBytes) return;
    PeerMessage m;
    const PeerDecoding decoding = decode(bytes.data(), kPeerMessageBytes, &m);
    if (decoding != PeerDecoding::ok) {
      // Once for all that is skipped until the next good one.
      if (!pieces->lost) ++(decoding == PeerDecoding::unknown_version ? other_version_ : damaged_);
      pieces->lost = true;
      drop(1, pieces);
      continue;
    }
    pieces->lost = false;
    drop(kPeerMessageBytes, pieces);
    if (m.robot != sender) {
      ++other_sender_;
      continue;
    }
    PeerReport r;
    r.robot = m.robot;
    r.session = m.segment >> kWorldBits;
    r.segment = m.segment & ((1u << kWorldBits) - 1);
    // 16 bits count for two hours at ten per second.
    const bool same = pieces->heard && pieces->session == r.session;
    const auto ahead = static_cast<std::int16_t>(m.sequence - pieces->sequence);
    r.sequence = same ? pieces->sequence + static_cast<std::uint32_t>(ahead) : m.sequence;
    r.t = m.t;
    r.T_W_B.p = m.p_W;
    r.covariance.topLeftCorner<3, 3>() = m.covariance;
    if (m.anchor) r.anchors = {{m.anchor->id, {m.t, m.anchor->p_W, m.anchor->covariance}}};
    auto heard = inbox_.add(r, now, arrival_s);
    if (!heard) continue;
    if (!same || ahead > 0) pieces->sequence = r.sequence;
    pieces->session = static_cast<std::uint32_t>(r.session);
    pieces->heard = true;
    out->push_back(std::move(*heard));
  }
}

std::vector<std::pair<std::string, long>> RadioInbox::counters() const {
  auto out = inbox_.counters();
  for (const auto& [name, count] : {std::pair<const char*, long>{"damaged", damaged_},
                                    {"foreign_bytes", foreign_bytes_},
                                    {"of_another_radio", other_sender_},
                                    {"other_version", other_version_},
                                    {"too_many_radios", too_many_}}) {
    if (count > 0) out.emplace_back(name, count);
  }
  return out;
}

}  // namespace vir::team
