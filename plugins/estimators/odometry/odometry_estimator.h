#pragma once
/// Estimator plugin `odometry`: MRPT observations to the odometry + range estimator and back.
#include "vir/estimator/odometry_range_estimator.h"
#include "vir/rawlog/labels.h"
#include "vir/roles/estimator.h"

namespace vir {

class OdometrySettings final : public roles::EstimatorSettings {
 public:
  void describe(OptionVisitor& v) override;
  std::vector<roles::EstimatorInput> inputs() const override;
  std::unique_ptr<roles::Estimator> create(const LogSink& log,
                                           std::function<void()> on_estimates) const override;

  estimator::OdometryRangeConfig config;
  std::string odometry_label = rawlog::kOdometryLabel;
  std::string range_label = rawlog::kRangeLabel;
};

class OdometryEstimator final : public roles::Estimator {
 public:
  /// Throws std::runtime_error if a file that the settings name cannot be read.
  OdometryEstimator(OdometrySettings settings, const LogSink& log);

  void add(const mrpt::obs::CObservation& observation) override;
  void finish() override {}
  roles::EstimatorOutput take() override;
  std::vector<Landmark> landmarks() const override { return {}; }
  std::vector<StampedPose> keyframes() const override { return estimator_.keyframes(); }
  std::vector<Anchor> anchors() const override { return estimator_.anchors(); }
  std::optional<SurveyFit> survey() const override { return estimator_.survey(); }
  roles::EstimatorReport report() const override;

 private:
  OdometrySettings settings_;
  estimator::OdometryRangeEstimator estimator_;
  int segments_ = 0;
};

}  // namespace vir
