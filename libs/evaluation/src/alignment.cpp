#include "vir/evaluation/alignment.h"

#include <Eigen/Dense>
#include <cmath>
#include <stdexcept>

namespace vir::evaluation {
namespace {

/// A reference whose positions spread less (rms) stands still: what they say of a rotation is
/// noise. Four hundredths of a metre are a robot on its legs, not on its way.
constexpr double kStanding = 0.04;

/// Moments of the two point sets about their means.
struct Moments {
  Vec3 mean_r = Vec3::Zero(), mean_e = Vec3::Zero();
  Mat3 cross = Mat3::Zero();  ///< mean of (r - mean_r)(e - mean_e)^T [m^2]
  double var_e = 0;           ///< mean of |e - mean_e|^2 [m^2]
  double var_r = 0;           ///< mean of |r - mean_r|^2 [m^2]
};

Moments momentsOf(const std::vector<PosePair>& pairs) {
  Moments m;
  const double n = static_cast<double>(pairs.size());
  for (const PosePair& pair : pairs) {
    m.mean_r += pair.reference.p / n;
    m.mean_e += pair.estimate.p / n;
  }
  for (const PosePair& pair : pairs) {
    const Vec3 r = pair.reference.p - m.mean_r;
    const Vec3 e = pair.estimate.p - m.mean_e;
    m.cross += r * e.transpose() / n;
    m.var_e += e.squaredNorm() / n;
    m.var_r += r.squaredNorm() / n;
  }
  return m;
}

/// Rotation R_R_E that agrees best with the attitudes (chordal mean).
Mat3 chordalSum(const std::vector<PosePair>& pairs) {
  Mat3 sum = Mat3::Zero();
  for (const PosePair& pair : pairs) {
    sum += (pair.reference.q * pair.estimate.q.conjugate()).toRotationMatrix();
  }
  return sum;
}

/// The rotation closest to M, and the smallest of the two singular values that fix it, relative to
/// the largest.
Mat3 closestRotation(const Mat3& M, double* well_posed, double* trace) {
  const Eigen::JacobiSVD<Mat3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vec3 sign = Vec3::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0) sign.z() = -1;
  const Vec3 s = svd.singularValues();
  *well_posed = s.x() > 0 ? (s.y() + sign.z() * s.z()) / s.x() : 0;
  *trace = s.dot(sign);
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

/// Angle about z that maximises trace(Rz^T M); false when every angle is as good.
bool yawOptimum(const Mat3& M, double scale, double* yaw) {
  const double c = M(0, 0) + M(1, 1);
  const double s = M(1, 0) - M(0, 1);
  *yaw = 0;
  if (!(std::hypot(c, s) > 1e-12 * scale)) return false;
  *yaw = std::atan2(s, c);
  return true;
}

void alignPosYaw(const std::vector<PosePair>& pairs, const Moments& m, AlignmentResult* result) {
  double yaw = 0;
  const double extent = std::max({m.var_r, m.var_e, 1e-12});
  const bool standing = std::sqrt(m.var_r) < kStanding;
  if (standing || !yawOptimum(m.cross, extent, &yaw)) {
    result->note = std::string("yaw is from the attitudes: ") +
                   (standing ? "the reference stands still" : "the positions do not determine it");
    yawOptimum(chordalSum(pairs), 1.0, &yaw);
  }
  result->T_R_E.q = Quat(rotZ(yaw));
}

void alignUmeyama(const std::vector<PosePair>& pairs, const Moments& m, bool with_scale,
                  AlignmentResult* result) {
  double well_posed = 0, trace = 0;
  Mat3 R = closestRotation(m.cross, &well_posed, &trace);
  const double extent = std::max({m.var_r, m.var_e, 1e-12});
  const bool standing = std::sqrt(m.var_r) < kStanding;
  if (standing || m.cross.norm() < 1e-12 * extent) {
    result->note = std::string("rotation is from the attitudes: ") +
                   (standing ? "the reference stands still" : "the positions do not determine it");
    double ignored = 0;
    R = closestRotation(chordalSum(pairs), &ignored, &ignored);
    trace = 0;
  } else if (well_posed < 1e-9) {
    result->note = "the rotation about the line of motion is not determined by the positions";
  }
  result->T_R_E.q = Quat(R).normalized();
  if (!with_scale) return;
  const double scale = m.var_e > 1e-18 ? trace / m.var_e : 0;
  if (scale > 1e-6) {
    result->scale = scale;
  } else {
    result->note += std::string(result->note.empty() ? "" : "; ") +
                    "scale is left at 1: the positions do not determine it";
  }
}

}  // namespace

bool parseAlignment(const std::string& word, Alignment* alignment) {
  for (const Alignment a : {Alignment::none, Alignment::posyaw, Alignment::se3, Alignment::sim3}) {
    if (word == name(a)) {
      *alignment = a;
      return true;
    }
  }
  return false;
}

const char* name(Alignment alignment) {
  switch (alignment) {
    case Alignment::none:
      return "none";
    case Alignment::posyaw:
      return "posyaw";
    case Alignment::se3:
      return "se3";
    case Alignment::sim3:
      return "sim3";
  }
  return "none";
}

AlignmentResult align(const std::vector<PosePair>& pairs, Alignment kind) {
  AlignmentResult result;
  if (kind == Alignment::none) return result;
  if (pairs.empty()) throw std::invalid_argument("align: there is no pair of poses");
  const Moments m = momentsOf(pairs);
  if (kind == Alignment::posyaw) {
    alignPosYaw(pairs, m, &result);
  } else {
    alignUmeyama(pairs, m, kind == Alignment::sim3, &result);
  }
  result.T_R_E.p = m.mean_r - result.scale * (result.T_R_E.q * m.mean_e);
  return result;
}

}  // namespace vir::evaluation
