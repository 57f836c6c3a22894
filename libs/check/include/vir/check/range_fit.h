#pragma once
/// Ranges to one anchor against a path that is known from elsewhere.
#include <optional>
#include <vector>

#include "vir/types/range.h"
#include "vir/types/state.h"

namespace vir::check {

/// Poses of the body in order of time, thinned out to what ranges need. Memory is bounded: what
/// comes after about half an hour is left out.
class KnownPath {
 public:
  /// In order of time; others are left out.
  void add(const StampedPose& T_W_B);
  /// Where the antenna at `p_B_U` [m] was; empty outside of the path and in its gaps.
  std::optional<Vec3> at(TimeNs t, const Vec3& p_B_U) const;
  /// The body then; empty likewise.
  std::optional<Pose> poseAt(TimeNs t) const;
  bool empty() const { return poses_.empty(); }
  TimeNs start() const { return poses_.front().t; }

 private:
  struct Around {
    const StampedPose *a, *b;
    double share;  ///< of the way from a to b
  };
  std::optional<Around> aroundOf(TimeNs t) const;

  std::vector<StampedPose> poses_;
};

/// An anchor by the ranges to it: range = |p_W - antenna(t + offset)| + bias.
struct AnchorFit {
  Vec3 p_W = Vec3::Zero();  ///< the anchor, in the path's world [m]
  double bias_m = 0;        ///< range - distance
  double bias_sigma_m = 0;  ///< by geometry and noise, the likeness of neighbours included
  double offset_s = 0;      ///< stamp of a range + this = the path's clock
  double offset_sigma_s = 0;
  double noise_m = 0;            ///< robust spread of what is left
  double independent = 0;        ///< so many independent ranges these are worth
  std::vector<Vec3> antennas_W;  ///< where the antenna was, of the ranges looked at
  std::vector<double> ranges_m;  ///< these
  std::vector<TimeNs> times;     ///< their stamps
  long used = 0;                 ///< ranges in the path's time
  bool found = false;
};

/// The best of many starts of a robust Gauss-Newton, with priors wide enough to do no harm.
/// `unit_m`: metres per unit of the ranges. `held`: the anchor's place, if that is known. Not found
/// with fewer than 30 ranges. Deterministic.
AnchorFit fitAnchor(const KnownPath& path, const std::vector<Range>& ranges, double unit_m = 1,
                    const std::optional<Vec3>& held = std::nullopt);

}  // namespace vir::check
