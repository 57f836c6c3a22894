#pragma once
/// Estimator plugin `odometry`: poses of a device and ranges to the odometry-and-range estimator.
#include <Eigen/Dense>

#include "vir/estimator/odometry_range_estimator.h"
#include "vir/pipeline/estimator.h"

namespace vir {

class OdometryEstimator final : public Estimator {
 public:
  void describe(OptionVisitor& v) override;
  void start(const LogSink& log) override;
  bool reads(const mrpt::obs::CObservation& observation) const override;
  void add(const mrpt::obs::CObservation& observation) override;
  void finish() override {}
  std::vector<StateEstimate> take() override;
  std::vector<LandmarkEstimate> landmarks() const override { return {}; }
  std::vector<KeyframeEstimate> keyframes() const override;
  std::vector<AnchorEstimate> anchors() const override;
  std::vector<RangeRecord> takeRanges() override;
  EstimatorReport report() const override;

 private:
  OdometryRangeConfig config_;
  std::string odometry_label_ = "ODOM";
  std::string range_label_ = "UWB0";
  std::unique_ptr<OdometryRangeEstimator> estimator_;
  int segments_ = 0;
};

}  // namespace vir
