#include "stamp_noise.h"

#include <algorithm>
#include <cmath>

#include "text.h"
#include "vir/core/order_statistics.h"

namespace vir::check {
namespace {

constexpr double kFastEnough = 0.2;  // [rad/s] below that turning tells no time
constexpr std::size_t kFewest = 40;
/// An estimate begins to suffer [s].
constexpr double kLeastS = 0.003;
/// Noise of the turning is alike along the axis and across it; stamps are off along it only.
constexpr double kTimesAcross = 2;
/// Standard deviations per median of absolute values.
constexpr double kPerMedian = 1.4826;

}  // namespace

std::optional<Finding> stampNoise(const std::vector<TurnPair>& pairs, const Mat3& R_C_B,
                                  const Vec3& bias, const std::string& camera_label) {
  std::vector<double> along, across;
  for (const TurnPair& p : pairs) {
    const Vec3 rate = R_C_B * (p.gyro_B - bias);
    const double speed = rate.norm();
    if (speed < kFastEnough) continue;
    const Vec3 axis = rate / speed;
    const Vec3 rest = (p.image_C - rate) * toSeconds(p.t1 - p.t0) / speed;
    along.push_back(axis.dot(rest));
    const Vec3 side = axis.unitOrthogonal();
    across.push_back(std::abs(side.dot(rest)));
    across.push_back(std::abs(axis.cross(side).dot(rest)));
  }
  if (along.size() < kFewest) return std::nullopt;
  const std::size_t turns = along.size();
  std::vector<double> copy = along;
  const double middle = medianInPlace(&copy);
  for (double& s : along) s = std::abs(s - middle);
  // Of the difference of two stamps.
  const double sigma = kPerMedian * medianInPlace(&along) / std::sqrt(2.0);
  const double noise = kPerMedian * medianInPlace(&across) / std::sqrt(2.0);
  if (sigma < kLeastS || sigma < kTimesAcross * noise) return std::nullopt;
  return Finding{Severity::doubtful,
                 "jitter",
                 camera_label,
                 "its stamps are off by about " + num(1e3 * sigma, 2) + " ms, each by itself",
                 "the images turn by as much more or less than the gyro between their stamps (" +
                     std::to_string(turns) + " turns; about other axes by " + num(1e3 * noise, 2) +
                     " ms' worth)",
                 "stamp the images when they are taken (the sensor's own stamps, or a trigger), "
                 "not when they arrive"};
}

}  // namespace vir::check
