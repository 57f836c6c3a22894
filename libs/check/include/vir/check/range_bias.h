#pragma once
/// The constant error of ranges, where the true path is known.
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "vir/check/finding.h"
#include "vir/types/range.h"
#include "vir/types/state.h"

namespace vir::check {

/// One anchor, from the ranges to it and where the antenna was.
struct AnchorFit {
  Vec3 p_W = Vec3::Zero();  ///< the anchor, in the ground truth's world [m]
  double bias_m = 0;        ///< range - distance
  double bias_sigma_m = 0;  ///< of the bias, by the geometry and the noise
  double noise_m = 0;       ///< robust spread of what is left
  long used = 0;
  bool found = false;
};

/// Position and bias of an anchor at `ranges` from the antenna at `points_W` (as many): the best of
/// several starts of a robust Gauss-Newton. Not found where there are fewer than 30 or the path
/// does not fix it.
AnchorFit fitAnchor(const std::vector<Vec3>& points_W, const std::vector<double>& ranges);

class RangeBiasCheck {
 public:
  explicit RangeBiasCheck(std::string label) : label_(std::move(label)) {}
  void add(const Range& range) { waiting_.push_back(range); }
  /// In time order with the ranges, as far as it is there.
  void addTruth(const StampedPose& T_W_B);
  std::vector<Finding> findings() const;

 private:
  struct Seen {
    std::vector<Vec3> points_W;
    std::vector<double> ranges;
  };
  std::string label_;
  std::vector<Range> waiting_;  ///< since the last pose
  StampedPose last_;
  bool any_ = false;
  std::map<std::uint64_t, Seen> anchors_;
};

}  // namespace vir::check
