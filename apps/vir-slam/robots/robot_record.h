#pragma once
/// What is left of a robot's run for those it meets.
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "robots/peer_observations.h"
#include "vir/evaluation/trajectory.h"
#include "vir/roles/estimator.h"

namespace vir::app {

struct AnchorSnapshot {
  TimeNs t = 0;
  std::vector<roles::AnchorEstimate> anchors;
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
  std::vector<evaluation::StampedPose> odometry;
  bool sees = false;  ///< images or feature tracks are recorded
  std::vector<roles::LandmarkEstimate> landmarks;
  std::vector<roles::KeyframeEstimate> keyframes;
  evaluation::Trajectory truth;

  std::optional<KnownPose> at(TimeNs t) const { return poseAt(poses, t); }
  /// The anchors as believed at `t`.
  const std::vector<roles::AnchorEstimate>& anchorsAt(TimeNs t) const;
};

/// Keeps ranges to robots and anchors, and odometry poses; whether there are images.
void noteObservation(const mrpt::obs::CObservation& observation, const std::string& peer_label,
                     RobotRecord* record);

/// Runs the estimator inside and keeps its poses and what it believed of anchors.
class RecordingEstimator final : public roles::Estimator {
 public:
  RecordingEstimator(std::unique_ptr<roles::Estimator> inner, RobotRecord* record)
      : inner_(std::move(inner)), record_(record) {}

  void describe(OptionVisitor& v) override { inner_->describe(v); }
  void start(const LogSink& log) override { inner_->start(log); }
  void add(const mrpt::obs::CObservation& observation) override { inner_->add(observation); }
  void finish() override { inner_->finish(); }
  std::vector<roles::StateEstimate> take() override;
  std::vector<roles::LandmarkEstimate> landmarks() const override { return inner_->landmarks(); }
  std::vector<roles::KeyframeEstimate> keyframes() const override { return inner_->keyframes(); }
  std::vector<roles::AnchorEstimate> anchors() const override { return inner_->anchors(); }
  std::vector<roles::RangeRecord> takeRanges() override { return inner_->takeRanges(); }
  roles::EstimatorReport report() const override { return inner_->report(); }

 private:
  std::unique_ptr<roles::Estimator> inner_;
  RobotRecord* record_;
};

}  // namespace vir::app
