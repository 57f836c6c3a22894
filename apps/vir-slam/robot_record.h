#pragma once
/// What is left of a robot's run for those it meets.
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "vir/evaluation/trajectory.h"
#include "vir/pipeline/estimator.h"

namespace vir::app {

/// A range to another robot as this one measured it.
struct PeerObservation {
  TimeNs t = 0;
  int peer = 0;
  double range_m = 0, sigma_m = 0;
  Vec3 p_B_U = Vec3::Zero();  ///< own antenna
};

/// A position with its covariance in its sender's world.
struct SentPosition {
  TimeNs t = 0;
  Vec3 p_W = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
};

struct KnownPose {
  TimeNs t = 0;
  Pose T_W_B;
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  int segment = 0;
};

struct AnchorSnapshot {
  TimeNs t = 0;
  std::vector<AnchorEstimate> anchors;
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
  std::map<int, std::vector<SentPosition>> heard;  ///< by the peer's id
  /// By the peer's id and the anchor's.
  std::map<std::pair<int, std::uint64_t>, std::vector<SentPosition>> heard_anchors;
  std::vector<AnchorRangeObservation> anchor_ranges;
  std::vector<StampedPose> odometry;
  std::vector<LandmarkEstimate> landmarks;
  std::vector<KeyframeEstimate> keyframes;
  Trajectory truth;

  /// Where the antenna was, between the two poses around `t`; empty where there is none within
  /// 0.5 s or a new world begins in between.
  std::optional<KnownPose> at(TimeNs t) const;
  /// The anchors as believed at `t`.
  const std::vector<AnchorEstimate>& anchorsAt(TimeNs t) const;
};

/// Runs the estimator inside and notes what passes.
class RecordingEstimator final : public Estimator {
 public:
  RecordingEstimator(std::unique_ptr<Estimator> inner, std::string peer_label, RobotRecord* record)
      : inner_(std::move(inner)), peer_label_(std::move(peer_label)), record_(record) {}

  void describe(OptionVisitor& v) override { inner_->describe(v); }
  void start(const LogSink& log) override { inner_->start(log); }
  void add(const mrpt::obs::CObservation& observation) override;
  void finish() override { inner_->finish(); }
  std::vector<StateEstimate> take() override;
  std::vector<LandmarkEstimate> landmarks() const override { return inner_->landmarks(); }
  std::vector<KeyframeEstimate> keyframes() const override { return inner_->keyframes(); }
  std::vector<AnchorEstimate> anchors() const override { return inner_->anchors(); }
  std::vector<RangeRecord> takeRanges() override { return inner_->takeRanges(); }
  EstimatorReport report() const override { return inner_->report(); }

 private:
  void note(const mrpt::obs::CObservation& observation);

  std::unique_ptr<Estimator> inner_;
  std::string peer_label_;
  RobotRecord* record_;
};

}  // namespace vir::app
