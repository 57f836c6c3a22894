#include "mirror.h"

#include <Eigen/Dense>
#include <cmath>

namespace vir::estimator {
namespace {

constexpr std::size_t kFewest = 10;
constexpr int kIterations = 6;
/// Closer than this [m], the two are one position.
constexpr double kSame = 0.1;

}  // namespace

MirrorComparison compareMirror(const window::LongWindow& window, std::uint64_t key,
                               const std::vector<window::HeldRange>& held,
                               const std::vector<window::HeldRange>& head_ranges,
                               const Vec3* mirror) {
  MirrorComparison out;
  if (held.size() < kFewest) return out;
  Vec3 mean = Vec3::Zero();
  for (const window::HeldRange& r : held) mean += r.motion;
  mean /= static_cast<double>(held.size());
  Mat3 scatter = Mat3::Zero();
  for (const window::HeldRange& r : held)
    scatter += (r.motion - mean) * (r.motion - mean).transpose();
  const Vec3 normal = Eigen::SelfAdjointEigenSolver<Mat3>(scatter).eigenvectors().col(0);
  Vec3 here = window.anchors().at(key).position();
  out.mirror_p_W = mirror ? *mirror : Vec3(here - 2 * normal.dot(here - mean) * normal);
  const double cost_here = window.costWithAnchorAt(key, here, kIterations, head_ranges, &here);
  out.chi2 =
      window.costWithAnchorAt(key, out.mirror_p_W, kIterations, head_ranges, &out.mirror_p_W) -
      cost_here;
  out.here_p_W = here;
  out.distinct = (out.mirror_p_W - here).norm() > kSame;
  out.valid = here.allFinite() && out.mirror_p_W.allFinite() && std::isfinite(out.chi2);
  return out;
}

}  // namespace vir::estimator
