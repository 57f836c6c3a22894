#include "robots/robot_recorder.h"

#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"

namespace vir::app {
namespace {

void append(const std::vector<Range>& ranges, std::vector<Range>* to) {
  to->insert(to->end(), ranges.begin(), ranges.end());
}

}  // namespace

void noteObservation(const mrpt::obs::CObservation& observation, const std::string& peer_label,
                     team::RobotRecord* record) {
  const std::string& label = observation.sensorLabel;
  if (label == peer_label) append(rawlog::rangesOf(observation), &record->peer_ranges);
  if (label == rawlog::kRangeLabel) append(rawlog::rangesOf(observation), &record->anchor_ranges);
  record->sees = record->sees || rawlog::isImage(observation);
  if (label != rawlog::kOdometryLabel) return;
  if (const auto pose = rawlog::poseOf(observation)) record->odometry.push_back(*pose);
}

void RobotRecorder::onOutput(const roles::EstimatorOutput& output,
                             const roles::Estimator& estimator) {
  for (const StateEstimate& e : output.states) team::keepPose(e, &record_->poses);
  for (const StampedPose& k : output.settled) keyframes_[k.t] = k.T_W_B;
  if (record_->snapshotDue()) record_->takeSnapshot(estimator.anchors());
}

void RobotRecorder::onEnd(const roles::Estimator& estimator, results::RunSummary* /*summary*/) {
  record_->landmarks = estimator.landmarks();
  for (const StampedPose& k : estimator.keyframes()) keyframes_[k.t] = k.T_W_B;
  for (const auto& [t, T_W_B] : keyframes_) record_->keyframes.push_back({t, T_W_B});
}

}  // namespace vir::app
