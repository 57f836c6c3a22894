#pragma once
/// An estimator that gives nothing but the keyframes that a test hands it.
#include <vector>

#include "vir/roles/estimator.h"

namespace vir::results {

class SilentEstimator : public roles::Estimator {
 public:
  void add(const mrpt::obs::CObservation&) override {}
  void finish() override {}
  roles::EstimatorOutput take() override { return {}; }
  std::vector<Landmark> landmarks() const override { return {}; }
  std::vector<StampedPose> keyframes() const override { return keyframes_; }
  roles::EstimatorReport report() const override { return {}; }

  std::vector<StampedPose> keyframes_;
};

}  // namespace vir::results
