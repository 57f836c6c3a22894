#include "robots/robot_record.h"

#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include <algorithm>

#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir::app {
namespace {

using namespace mrpt::obs;

constexpr TimeNs kSnapshotEvery = 200000000;
constexpr const char* kOdometryLabel = "ODOM";
constexpr const char* kAnchorRangeLabel = "UWB0";

}  // namespace

const std::vector<roles::AnchorEstimate>& RobotRecord::anchorsAt(TimeNs t) const {
  static const std::vector<roles::AnchorEstimate> kNone;
  const auto next =
      std::upper_bound(anchors.begin(), anchors.end(), t,
                       [](TimeNs stamp, const AnchorSnapshot& s) { return stamp < s.t; });
  return next == anchors.begin() ? kNone : (next - 1)->anchors;
}

void noteObservation(const mrpt::obs::CObservation& observation, const std::string& peer_label,
                     RobotRecord* record) {
  const std::string& label = observation.sensorLabel;
  for (const PeerObservation& r : peerRangesOf(observation, peer_label)) {
    record->peer_ranges.push_back(r);
  }
  if (label == kAnchorRangeLabel) {
    for (const PeerObservation& r : peerRangesOf(observation, label)) {
      const auto anchor = static_cast<std::uint32_t>(r.peer);
      record->anchor_ranges.push_back({r.t, anchor, r.range_m, r.sigma_m, r.p_B_U});
    }
  }
  record->sees = record->sees || dynamic_cast<const CObservationImage*>(&observation) != nullptr ||
                 dynamic_cast<const CObservationStereoImagesFeatures*>(&observation) != nullptr;
  const auto* pose = dynamic_cast<const CObservationRobotPose*>(&observation);
  if (pose != nullptr && label == kOdometryLabel) {
    record->odometry.push_back(
        {rawlog::fromMrptTime(pose->timestamp), rawlog::fromMrptPose(pose->pose.mean)});
  }
}

std::vector<roles::StateEstimate> RecordingEstimator::take() {
  const std::vector<roles::StateEstimate> estimates = inner_->take();
  for (const roles::StateEstimate& e : estimates) {
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
