#pragma once
/// Estimator plugin `odometry`: poses of a device and ranges to the odometry-and-range estimator.
#include <Eigen/Dense>

#include "vir/estimator/odometry_range_estimator.h"
#include "vir/roles/estimator.h"

namespace vir {

class OdometryEstimator final : public roles::Estimator {
 public:
  void describe(OptionVisitor& v) override;
  void start(const LogSink& log) override;
  bool reads(const mrpt::obs::CObservation& observation) const override;
  void add(const mrpt::obs::CObservation& observation) override;
  void finish() override {}
  std::vector<roles::StateEstimate> take() override;
  std::vector<roles::LandmarkEstimate> landmarks() const override { return {}; }
  std::vector<roles::KeyframeEstimate> keyframes() const override;
  std::vector<roles::AnchorEstimate> anchors() const override;
  std::vector<roles::RangeRecord> takeRanges() override;
  roles::EstimatorReport report() const override;

 private:
  estimator::OdometryRangeConfig config_;
  std::string odometry_label_ = "ODOM";
  std::string range_label_ = "UWB0";
  std::unique_ptr<estimator::OdometryRangeEstimator> estimator_;
  int segments_ = 0;
};

}  // namespace vir
