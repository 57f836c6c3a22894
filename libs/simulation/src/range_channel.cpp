#include "range_channel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace vir::simulation {
namespace {

/// Positions farther away are none [m].
constexpr double kFarthestM = 1e8;

double curve(const std::vector<double>& points, double x) {
  if (points.empty()) return 0;
  if (x <= points[0]) return points[1];
  for (std::size_t k = 2; k < points.size(); k += 2) {
    if (x > points[k]) continue;
    const double s = (x - points[k - 2]) / (points[k] - points[k - 2]);
    return points[k - 1] + s * (points[k + 1] - points[k - 1]);
  }
  return points.back();
}

}  // namespace

RangeChannel::RangeChannel(const RangeSimulationOptions& o, std::uint64_t stream,
                           const rendering::Scene* scene)
    : o_(o), scene_(scene), random_(static_cast<std::uint64_t>(o.seed), stream) {}

SimulatedRange RangeChannel::measure(const Vec3& a, const Vec3& b, double dt) {
  const double white = random_.normal(), innovation = random_.normal();
  const double block = random_.uniform(), length = random_.uniform(), lost = random_.uniform();
  const double keep = started_ ? std::exp(-dt / o_.correlated_s) : 0;
  correlated_ = keep * correlated_ + std::sqrt(1 - keep * keep) * innovation;
  updateBlocked(dt, block, length);
  const double solid = scene_ ? scene_->solidBetween(a, b) : 0;
  // The way round an obstacle is the same as long as it stands there.
  if (solid > 0 && !scene_blocked_) {
    scene_excess_ = o_.nlos_min_m + (o_.nlos_max_m - o_.nlos_min_m) * length;
  }
  scene_blocked_ = solid > 0;
  started_ = true;
  SimulatedRange r;
  r.true_m = (a - b).norm();
  r.line_of_sight = !blocked_ && !scene_blocked_;
  const double excess = (blocked_ ? excess_ : 0) + (scene_blocked_ ? scene_excess_ : 0);
  r.range_m = std::max(0.0, r.true_m + o_.bias_m + curve(o_.bias_curve, r.true_m) +
                                o_.sigma_m * white + o_.correlated_sigma_m * correlated_ + excess);
  lost_ = lost < o_.dropped_share || r.true_m > o_.max_distance_m || solid > o_.max_solid_m;
  return r;
}

void RangeChannel::updateBlocked(double dt, double block, double length) {
  const double excess = o_.nlos_min_m + (o_.nlos_max_m - o_.nlos_min_m) * length;
  if (o_.nlos_burst_s <= 0) {
    blocked_ = block < o_.nlos_share;
    excess_ = excess;
    return;
  }
  // Two states whose mean stays keep the share; the excess belongs to the obstacle.
  const double share = std::min(o_.nlos_share, 0.999);
  const double free_s = o_.nlos_burst_s * (1 - share) / std::max(share, 1e-9);
  const double leave = started_ ? 1 - std::exp(-dt / (blocked_ ? o_.nlos_burst_s : free_s)) : share;
  if (block >= leave) return;
  blocked_ = !blocked_;
  if (blocked_) excess_ = excess;
}

void checkRangeOptions(const RangeSimulationOptions& o) {
  const auto refuse = [](const std::string& what) {
    throw std::invalid_argument("simulated ranges: " + what);
  };
  if (o.anchor_m.size() % 3 != 0) refuse("anchor_m must hold 3 numbers per anchor");
  if (!o.anchor_id.empty() && o.anchor_id.size() != o.anchor_m.size() / 3) {
    refuse("anchor_id must hold one number per anchor");
  }
  if (o.lever_arm_m.size() != 3) refuse("lever_arm_m must hold 3 numbers");
  const auto far = [](double x) { return !(std::abs(x) <= kFarthestM); };
  const auto any_far = [far](const std::vector<double>& v) {
    return std::any_of(v.begin(), v.end(), far);
  };
  if (any_far(o.lever_arm_m) || any_far(o.anchor_m) || any_far(o.jump)) {
    refuse("lever_arm_m, anchor_m and jump must be within 100,000 km");
  }
  for (const double id : o.anchor_id) {
    if (!(std::abs(id) <= std::numeric_limits<int>::max())) refuse("anchor_id must fit in 32 bits");
  }
  if (o.bias_curve.size() % 2 != 0) refuse("bias_curve must hold pairs (distance, bias)");
  if (o.jump.size() % 5 != 0) refuse("jump must hold 5 numbers (index, time, x, y, z) per jump");
  if (!(o.rate_hz > 0)) refuse("rate_hz must be positive");
}

int anchorId(const RangeSimulationOptions& o, std::size_t index) {
  return o.anchor_id.empty() ? static_cast<int>(index) : static_cast<int>(o.anchor_id[index]);
}

}  // namespace vir::simulation
