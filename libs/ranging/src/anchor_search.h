#pragma once
/// The steps of anchor initialisation between the starts and the verdict.
#include <optional>
#include <vector>

#include "anchor_starts.h"
#include "range_fit.h"

namespace vir::ranging {

/// A local optimum of the robust cost.
struct Optimum {
  FitState x;
  double cost = 0;
  bool merged = false;  ///< stands for two mirror images that lie within the noise
};

class AnchorSearch {
 public:
  AnchorSearch(const FitData& data, const AnchorInitOptions& options,
               const std::optional<AnchorPrior>& prior);

  /// Optima that are not significantly worse than the best, best first; fixes scale and worth.
  std::vector<Optimum> run();
  /// The solution as handed out: least squares on the inliers, with an honest covariance.
  AnchorSolution solution(const Optimum& optimum);
  /// Does every point of the ring around the path's line fit as well?
  bool ringFits(const Optimum& best) const;

  const PathShape& shape() const { return shape_; }
  double scale() const { return scale_; }
  double worth() const { return worth_; }
  /// Outliers at the best optimum.
  int tooLong() const { return too_long_; }
  int tooShort() const { return too_short_; }
  /// Share of the newest fifth of the ranges that fit the best optimum.
  double newestShare() const { return newest_share_; }

 private:
  std::vector<Optimum> refined(const std::vector<FitState>& starts, const RangeFit& fit,
                               int iterations) const;
  std::vector<FitState> withMirrors(const std::vector<Optimum>& optima) const;
  void fixFactors(const FitState& best);
  void countOutliers(const FitState& best);
  std::vector<char> inliers(const FitState& x) const;
  bool separated(const Optimum& a, const Optimum& b, Optimum* middle) const;
  double profileSigma(const FitState& x, double cost, const Vec3& direction, double guess) const;
  double commonDrift(const std::vector<char>& inliers) const;
  void widenAlongWeakAxes(const Optimum& optimum, const FitState& x, Mat4* covariance) const;

  const FitData& data_;
  const AnchorInitOptions& options_;
  std::optional<AnchorPrior> prior_;
  PathShape shape_;
  FitData coarse_data_, probe_data_;
  RangeFit full_, coarse_,
      probe_;  // all ranges; few, to find optima; some, for what costs many fits
  double scale_ = 1, worth_ = 1;
  int too_long_ = 0, too_short_ = 0;
  double newest_share_ = 1;
};

}  // namespace vir::ranging
