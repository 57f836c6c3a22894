#include "robots/peer_observations.h"

#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>
#include <charconv>

#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir::app {
namespace {

using mrpt::obs::CObservationBeaconRanges;
using mrpt::obs::CObservationRobotPose;

constexpr TimeNs kLongestGap = 500000000;
constexpr double kNearMirror = 1.0;  // [m]; closer together, two mirror images are one anchor

/// "1" or "1:ANCHOR:4" behind "PEER:".
bool parseSender(const std::string& text, PeerBroadcast* out) {
  const char* const end = text.data() + text.size();
  const auto id = std::from_chars(text.data(), end, out->peer);
  if (id.ec != std::errc()) return false;
  if (id.ptr == end) return true;
  const std::string rest(id.ptr, end), prefix = ":ANCHOR:";
  if (rest.rfind(prefix, 0) != 0) return false;
  std::uint64_t value = 0;
  const char* const last = rest.data() + rest.size();
  const auto number = std::from_chars(rest.data() + prefix.size(), last, value);
  if (number.ec != std::errc() || number.ptr != last) return false;
  out->anchor = value;
  return true;
}

SentPosition sentPositionOf(const CObservationRobotPose& o) {
  SentPosition out;
  out.t = rawlog::fromMrptTime(o.timestamp);
  out.p_W = Vec3(o.pose.mean.x(), o.pose.mean.y(), o.pose.mean.z());
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) out.covariance(r, c) = o.pose.cov(r, c);
  }
  return out;
}

}  // namespace

std::vector<PeerObservation> peerRangesOf(const mrpt::obs::CObservation& observation,
                                          const std::string& peer_label) {
  std::vector<PeerObservation> out;
  if (observation.sensorLabel != peer_label) return out;
  const auto* ranges = dynamic_cast<const CObservationBeaconRanges*>(&observation);
  if (ranges == nullptr) return out;
  for (const auto& m : ranges->sensedData) {
    const auto& lever = m.sensorLocationOnRobot;
    out.push_back({rawlog::fromMrptTime(ranges->timestamp), m.beaconID,
                   static_cast<double>(m.sensedDistance), static_cast<double>(ranges->stdError),
                   Vec3(lever.x(), lever.y(), lever.z())});
  }
  return out;
}

std::optional<PeerBroadcast> broadcastOf(const mrpt::obs::CObservation& observation,
                                         const std::string& peer_label, long* unusable) {
  const std::string& label = observation.sensorLabel;
  const std::size_t n = peer_label.size();
  if (label.size() <= n + 1 || label[n] != ':' || label.compare(0, n, peer_label) != 0) {
    return std::nullopt;
  }
  const auto* pose = dynamic_cast<const CObservationRobotPose*>(&observation);
  PeerBroadcast out;
  if (pose != nullptr && parseSender(label.substr(n + 1), &out)) {
    out.sent = sentPositionOf(*pose);
    if (out.sent.p_W.allFinite() && out.sent.covariance.allFinite()) return out;
  }
  ++*unusable;
  return std::nullopt;
}

std::optional<KnownPose> poseAt(const std::vector<KnownPose>& poses, TimeNs t) {
  const auto next = std::lower_bound(poses.begin(), poses.end(), t,
                                     [](const KnownPose& p, TimeNs stamp) { return p.t < stamp; });
  if (next != poses.end() && next->t == t) return *next;
  if (next == poses.begin() || next == poses.end()) return std::nullopt;
  const auto before = next - 1;
  if (next->t - before->t > kLongestGap || next->segment != before->segment) return std::nullopt;
  const double u = toSeconds(t - before->t) / toSeconds(next->t - before->t);
  KnownPose out = *before;
  out.t = t;
  out.T_W_B.p += u * (next->T_W_B.p - before->T_W_B.p);
  out.T_W_B.q = before->T_W_B.q.slerp(u, next->T_W_B.q);
  return out;
}

std::optional<SentPosition> believed(const Anchor& a) {
  if (!a.has_position || !a.p_W.allFinite() || !a.covariance.allFinite()) return std::nullopt;
  SentPosition out{0, a.p_W, a.covariance};
  if (a.state == AnchorState::mirror_open) {
    // Its covariance spans both positions.
    if (!((a.mirror_p_W - a.p_W).norm() < kNearMirror)) return std::nullopt;
  } else if (a.state != AnchorState::estimated && a.state != AnchorState::fixed) {
    return std::nullopt;
  }
  return out;
}

}  // namespace vir::app
