#include <cmath>
#include <limits>
#include <nlopt.hpp>

#include "starts.h"
#include "vir/core/angles.h"

namespace vir::team {
namespace {

constexpr int kSectors = 24;

struct Search {
  const EvidenceCost* cost;
  const MutualRange* pivot;
  std::vector<std::pair<double, Vec4>> best;

  Vec4 at(const double* p) const {
    // p: yaw, azimuth, height of the direction's end (uniform on the sphere)
    const double flat = std::sqrt(std::max(0.0, 1 - p[2] * p[2]));
    const Vec3 direction(flat * std::cos(p[1]), flat * std::sin(p[1]), p[2]);
    const Vec3 offset = pivot->p_A + pivot->range_m * direction - rotZ(p[0]) * pivot->p_B;
    return {p[0], offset.x(), offset.y(), offset.z()};
  }
};

double objective(unsigned, const double* p, double*, void* data) {
  auto* search = static_cast<Search*>(data);
  const Vec4 x = search->at(p);
  const double cost = (*search->cost)(x);
  const int sector = static_cast<int>((p[0] + kPi) / (2 * kPi) * kSectors) % kSectors;
  auto& best = search->best[static_cast<std::size_t>(std::max(sector, 0))];
  if (cost < best.first) best = {cost, x};
  return cost;
}

}  // namespace

std::vector<Vec4> startsFromGlobalSearch(const EvidenceCost& cost, int evaluations) {
  std::vector<Vec4> out;
  if (cost.size() == 0) return out;
  // Three pivots: one may be an outlier.
  constexpr std::size_t kPivots = 3;
  for (std::size_t i = 0; i < kPivots; ++i) {
    Search search;
    search.cost = &cost;
    search.pivot = &cost.ranges()[i * (cost.size() - 1) / (kPivots - 1)];
    search.best.assign(kSectors, {std::numeric_limits<double>::infinity(), Vec4::Zero()});
    nlopt::opt direct(nlopt::GN_DIRECT_L, 3);
    direct.set_lower_bounds({-kPi, -kPi, -1});
    direct.set_upper_bounds({kPi, kPi, 1});
    direct.set_min_objective(objective, &search);
    direct.set_maxeval(evaluations / static_cast<int>(kPivots));
    std::vector<double> p{0.1, 0.1, 0.0};
    double value = 0;
    try {
      direct.optimize(p, value);
    } catch (const std::exception&) {
      // The best points seen are kept all the same.
    }
    for (std::size_t s = 0; s < search.best.size(); ++s) {
      const auto& before = search.best[(s + kSectors - 1) % kSectors];
      const auto& after = search.best[(s + 1) % kSectors];
      const auto& here = search.best[s];
      if (std::isfinite(here.first) && here.first <= before.first && here.first < after.first) {
        out.push_back(here.second);
      }
    }
  }
  return out;
}

}  // namespace vir::team
