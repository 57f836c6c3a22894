#include "robot_record.h"

#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>
#include <charconv>

#include "vir/pipeline/mrpt_pose.h"
#include "vir/pipeline/mrpt_time.h"

namespace vir::app {
namespace {

using mrpt::obs::CObservationBeaconRanges;
using mrpt::obs::CObservationRobotPose;

constexpr TimeNs kLongestGap = 500000000;
constexpr TimeNs kSnapshotEvery = 200000000;
constexpr const char* kOdometryLabel = "ODOM";
constexpr const char* kAnchorRangeLabel = "UWB0";

/// "1" or "1:ANCHOR:4" behind "PEER:".
bool parsePeerLabel(const std::string& text, int* peer, std::optional<std::uint64_t>* anchor) {
  const char* const end = text.data() + text.size();
  const auto id = std::from_chars(text.data(), end, *peer);
  if (id.ec != std::errc()) return false;
  if (id.ptr == end) return true;
  const std::string rest(id.ptr, end), prefix = ":ANCHOR:";
  if (rest.rfind(prefix, 0) != 0) return false;
  std::uint64_t value = 0;
  const char* const last = rest.data() + rest.size();
  const auto number = std::from_chars(rest.data() + prefix.size(), last, value);
  if (number.ec != std::errc() || number.ptr != last) return false;
  *anchor = value;
  return true;
}

SentPosition sentPositionOf(const CObservationRobotPose& o) {
  SentPosition out;
  out.t = fromMrptTime(o.timestamp);
  out.p_W = Vec3(o.pose.mean.x(), o.pose.mean.y(), o.pose.mean.z());
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) out.covariance(r, c) = o.pose.cov(r, c);
  }
  return out;
}

}  // namespace

std::optional<KnownPose> RobotRecord::at(TimeNs t) const {
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

const std::vector<AnchorEstimate>& RobotRecord::anchorsAt(TimeNs t) const {
  static const std::vector<AnchorEstimate> kNone;
  const auto next =
      std::upper_bound(anchors.begin(), anchors.end(), t,
                       [](TimeNs stamp, const AnchorSnapshot& s) { return stamp < s.t; });
  return next == anchors.begin() ? kNone : (next - 1)->anchors;
}

void RecordingEstimator::note(const mrpt::obs::CObservation& observation) {
  const std::string& label = observation.sensorLabel;
  if (const auto* ranges = dynamic_cast<const CObservationBeaconRanges*>(&observation)) {
    const TimeNs t = fromMrptTime(ranges->timestamp);
    for (const auto& m : ranges->sensedData) {
      const Vec3 lever(m.sensorLocationOnRobot.x(), m.sensorLocationOnRobot.y(),
                       m.sensorLocationOnRobot.z());
      const double d = static_cast<double>(m.sensedDistance);
      const double sigma = static_cast<double>(ranges->stdError);
      if (label == peer_label_) record_->peer_ranges.push_back({t, m.beaconID, d, sigma, lever});
      if (label == kAnchorRangeLabel) {
        record_->anchor_ranges.push_back(
            {t, static_cast<std::uint32_t>(m.beaconID), d, sigma, lever});
      }
    }
    return;
  }
  const auto* pose = dynamic_cast<const CObservationRobotPose*>(&observation);
  if (pose == nullptr) return;
  if (label == kOdometryLabel) {
    record_->odometry.push_back({fromMrptTime(pose->timestamp), fromMrptPose(pose->pose.mean)});
  }
  const std::string prefix = peer_label_ + ":";
  if (label.rfind(prefix, 0) != 0) return;
  int peer = 0;
  std::optional<std::uint64_t> anchor;
  if (!parsePeerLabel(label.substr(prefix.size()), &peer, &anchor)) return;
  const SentPosition sent = sentPositionOf(*pose);
  if (!sent.p_W.allFinite() || !sent.covariance.allFinite()) return;
  (anchor ? record_->heard_anchors[{peer, *anchor}] : record_->heard[peer]).push_back(sent);
}

void RecordingEstimator::add(const mrpt::obs::CObservation& observation) {
  note(observation);
  inner_->add(observation);
}

std::vector<StateEstimate> RecordingEstimator::take() {
  const std::vector<StateEstimate> estimates = inner_->take();
  for (const StateEstimate& e : estimates) {
    if (!e.valid || !e.T_W_B.p.allFinite()) continue;
    if (!record_->poses.empty() && e.t <= record_->poses.back().t) continue;
    record_->poses.push_back({e.t, e.T_W_B, e.covariance, e.segment});
  }
  if (!record_->poses.empty() &&
      (record_->anchors.empty() ||
       record_->poses.back().t >= record_->anchors.back().t + kSnapshotEvery)) {
    record_->anchors.push_back({record_->poses.back().t, inner_->anchors()});
  }
  return estimates;
}

}  // namespace vir::app
