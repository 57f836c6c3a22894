#pragma once
#include <cstddef>
#include <string>

#include "kept_rows.h"
#include "vir/core/thinned_out.h"
#include "vir/roles/estimator.h"

namespace vir::results {

struct PoseRow {
  TimeNs t;
  double q[4], p[3];  // x y z w; [m]
};
inline PoseRow rowOf(const StampedPose& pose) {
  PoseRow row{pose.t, {}, {}};
  Eigen::Map<Eigen::Vector4d>(row.q) = pose.T_W_B.q.coeffs();
  Eigen::Map<Vec3>(row.p) = pose.T_W_B.p;
  return row;
}

inline StampedPose poseOf(const PoseRow& row) {
  StampedPose pose;
  pose.t = row.t;
  pose.T_W_B.q.coeffs() = Eigen::Map<const Eigen::Vector4d>(row.q);
  pose.T_W_B.p = Eigen::Map<const Vec3>(row.p);
  return pose;
}

struct EstimateRow {
  PoseRow pose;
  double covariance[9];  // of the position [m^2]
};

struct CpuRow {
  TimeNs t;
  double ms;
};

/// What a run brings image by image.
class LongRun {
 public:
  explicit LongRun(const std::string& folder)
      : poses(folder), truth(folder), settled(folder), cpu_ms(folder) {}
  KeptRows<EstimateRow> poses;
  KeptRows<PoseRow> truth;
  KeptRows<PoseRow> settled;
  KeptRows<CpuRow> cpu_ms;
  ThinnedOut<roles::CalibrationPoint> calibrations{1000};
};

}  // namespace vir::results
