#pragma once
/// Fills a robot's record from its run and its recording.
#include <map>
#include <string>

#include "vir/results/run_observer.h"
#include "vir/team/robot_record.h"

namespace vir::app {

/// Keeps ranges to robots and anchors, and odometry poses; whether there are images.
void noteObservation(const mrpt::obs::CObservation& observation, const std::string& peer_label,
                     team::RobotRecord* record);

/// Keeps the poses of a run and what it believed of anchors.
class RobotRecorder final : public results::RunObserver {
 public:
  explicit RobotRecorder(team::RobotRecord* record) : record_(record) {}
  void onOutput(const roles::EstimatorOutput& output, const roles::Estimator& estimator) override;
  void onEnd(const roles::Estimator& estimator, results::RunSummary* summary) override;

 private:
  team::RobotRecord* record_;
  std::map<TimeNs, Pose> keyframes_;
};

}  // namespace vir::app
