#pragma once
/// What is left of a robot's run for those it meets.
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "robots/peer_observations.h"
#include "vir/evaluation/trajectory.h"
#include "vir/results/run_observer.h"

namespace vir::app {

struct AnchorSnapshot {
  TimeNs t = 0;
  std::vector<Anchor> anchors;
};

/// An anchor range or an odometry pose as recorded, for the joint solution.
struct AnchorRangeObservation {
  TimeNs t = 0;
  std::uint64_t anchor = 0;
  double range_m = 0, sigma_m = 0;
  Vec3 p_B_U = Vec3::Zero();
};

struct RobotRecord {
  std::string name;
  int id = 0;  ///< as beacon in the others' recordings
  std::vector<KnownPose> poses;
  std::vector<AnchorSnapshot> anchors;
  std::vector<PeerObservation> peer_ranges;
  std::vector<AnchorRangeObservation> anchor_ranges;
  std::vector<StampedPose> odometry;
  bool sees = false;  ///< images or feature tracks are recorded
  std::vector<Landmark> landmarks;
  std::vector<StampedPose> keyframes;
  Trajectory truth;

  std::optional<KnownPose> at(TimeNs t) const { return poseAt(poses, t); }
  /// The anchors as believed at `t`.
  const std::vector<Anchor>& anchorsAt(TimeNs t) const;
};

/// Keeps ranges to robots and anchors, and odometry poses; whether there are images.
void noteObservation(const mrpt::obs::CObservation& observation, const std::string& peer_label,
                     RobotRecord* record);

/// Keeps the poses of a run and what it believed of anchors.
class RobotRecorder final : public results::RunObserver {
 public:
  explicit RobotRecorder(RobotRecord* record) : record_(record) {}
  void onOutput(const roles::EstimatorOutput& output, const roles::Estimator& estimator) override;
  void onEnd(const roles::Estimator& estimator, results::RunSummary* summary) override;

 private:
  RobotRecord* record_;
};

}  // namespace vir::app
