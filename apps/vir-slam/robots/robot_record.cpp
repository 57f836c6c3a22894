#include "robots/robot_record.h"

#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include <algorithm>

#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir::app {
namespace {

using namespace mrpt::obs;

constexpr TimeNs kSnapshotEvery = 200000000;

}  // namespace

const std::vector<Anchor>& RobotRecord::anchorsAt(TimeNs t) const {
  static const std::vector<Anchor> kNone;
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
  if (label == rawlog::kRangeLabel) {
    for (const PeerObservation& r : peerRangesOf(observation, label)) {
      const auto anchor = static_cast<std::uint32_t>(r.peer);
      record->anchor_ranges.push_back({r.t, anchor, r.range_m, r.sigma_m, r.p_B_U});
    }
  }
  record->sees = record->sees || dynamic_cast<const CObservationImage*>(&observation) != nullptr ||
                 dynamic_cast<const CObservationStereoImagesFeatures*>(&observation) != nullptr;
  const auto* pose = dynamic_cast<const CObservationRobotPose*>(&observation);
  if (pose != nullptr && label == rawlog::kOdometryLabel) {
    record->odometry.push_back(
        {rawlog::fromMrptTime(pose->timestamp), rawlog::fromMrptPose(pose->pose.mean)});
  }
}

void RobotRecorder::onOutput(const roles::EstimatorOutput& output,
                             const roles::Estimator& estimator) {
  std::vector<KnownPose>& poses = record_->poses;
  for (const StateEstimate& e : output.states) {
    if (!e.valid || !e.state.T_W_B.p.allFinite()) continue;
    if (!poses.empty() && e.state.t <= poses.back().t) continue;
    poses.push_back({e.state.t, e.state.T_W_B, e.covariance, e.segment});
  }
  if (poses.empty()) return;
  if (record_->anchors.empty() || poses.back().t >= record_->anchors.back().t + kSnapshotEvery) {
    record_->anchors.push_back({poses.back().t, estimator.anchors()});
  }
}

void RobotRecorder::onEnd(const roles::Estimator& estimator, results::RunSummary* /*summary*/) {
  record_->landmarks = estimator.landmarks();
  record_->keyframes = estimator.keyframes();
}

}  // namespace vir::app
