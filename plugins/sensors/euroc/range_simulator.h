#pragma once
/// Ranges to fixed anchors, drawn from the ground truth as the paper does.
#include <cstdint>
#include <memory>
#include <vector>

#include "euroc_options.h"
#include "readers.h"
#include "vir/core/random.h"

namespace vir::euroc {

struct SimulatedRange {
  TimeNs t = 0;
  int anchor = 0;
  double range_m = 0;
  bool line_of_sight = true;
};

/// Streams ranges in time order while it reads the ground truth once. Every anchor answers
/// `range_rate_hz` times a second, at times jittered by up to 40 % of the period; the pose is
/// interpolated between the neighbouring poses (slerp). Gaps of the ground truth longer than
/// kMaxGap give no ranges; they are counted in the log.
class RangeSimulator {
 public:
  static constexpr TimeNs kMaxGap = 100'000'000;

  /// `T_B_I` turns the ground truth's body into ours (the IMU).
  RangeSimulator(const EurocOptions& o, std::unique_ptr<RowStream<PoseRow>> truth,
                 const Pose& T_B_I, ProblemLog* log);

  const SimulatedRange* peek() const { return has_next_ ? &next_ : nullptr; }
  void pop() { advance(); }

 private:
  struct Anchor {
    int id = 0;
    Vec3 p_W = Vec3::Zero();
    std::int64_t slot = 0;  ///< index of the next period
    TimeNs t = 0;           ///< time of the next range
  };

  void schedule(Anchor* a);
  void advance();
  bool poseAt(TimeNs t, Pose* T_W_B);

  EurocOptions options_;
  std::unique_ptr<RowStream<PoseRow>> truth_;
  Pose T_B_I_;
  ProblemLog* log_;
  Random random_;
  std::vector<Anchor> anchors_;
  TimeNs start_ = 0;
  PoseRow before_, after_;
  bool has_next_ = false;
  SimulatedRange next_;
};

}  // namespace vir::euroc
