#pragma once
/// Least squares for one anchor, its bias and the scale of the path, robust or on chosen ranges.
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "vir/ranging/anchor_initialization.h"

namespace vir::ranging {

using Vec4 = Eigen::Vector4d;
using Mat4 = Eigen::Matrix4d;
/// Position, bias, log of the path's scale.
using Vec5 = Eigen::Matrix<double, 5, 1>;
using Mat5 = Eigen::Matrix<double, 5, 5>;

/// Beyond so many standard deviations a range does not fit.
constexpr double kInlierSigma = 3;
/// Robust standard deviation of whitened residuals; 1 where they agree with their sigma. Outliers
/// are all on one side and would widen even a median, so they are cut off step by step.
double robustScale(std::vector<double> r);

/// What the fit is made from; sigma includes the path's drift.
struct FitData {
  std::vector<Vec3> p;
  std::vector<double> z, sigma;
  std::vector<double> drift;  ///< of the path from here to its end, standard deviation [m]
  std::size_t size() const { return z.size(); }
  /// About `count` of the ranges, evenly spread.
  FitData thinned(std::size_t count) const;
};

/// Position, bias, and the log of the factor by which the path is too short, seen from its end.
struct FitState {
  Vec3 a = Vec3::Zero();
  double b = 0;
  double s = 0;
};

class RangeFit {
 public:
  RangeFit(const FitData* data, const AnchorInitOptions* options,
           const std::optional<AnchorPrior>& prior);

  /// Factor on every variance: in the loss (`scale`, from the residuals' size) and on the weight of
  /// the data against the priors (`worth`, from their correlation).
  void setFactors(double scale, double worth) { scale_ = scale, worth_ = worth; }
  /// minimise() ends when a step gains less than this share of the cost.
  void setTolerance(double tolerance) { tolerance_ = tolerance; }
  /// Plain least squares on ranges with a flag; nullptr: robust loss on all.
  void setInliers(const std::vector<char>* inliers) { inliers_ = inliers; }

  double cost(const FitState& x) const;
  /// Levenberg-Marquardt from `x`; the coordinate along `fixed` (unit, may be null) stays.
  FitState minimise(FitState x, int iterations, const Vec3* fixed = nullptr,
                    double* cost = nullptr) const;
  /// Gauss-Newton information of position, bias and scale, priors included.
  Mat5 information(const FitState& x) const;
  /// (measured - predicted) / sigma as claimed.
  std::vector<double> residuals(const FitState& x) const;
  const FitData& data() const { return *data_; }

 private:
  double build(const FitState& x, Mat5* H, Vec5* g) const;
  void addPriors(const FitState& x, double* cost, Mat5* H, Vec5* g) const;

  const FitData* data_;
  const AnchorInitOptions* options_;
  Mat3 prior_information_ = Mat3::Zero();
  Vec3 prior_mean_ = Vec3::Zero();
  const std::vector<char>* inliers_ = nullptr;
  double scale_ = 1, worth_ = 1, tolerance_ = 1e-9;
};

}  // namespace vir::ranging
