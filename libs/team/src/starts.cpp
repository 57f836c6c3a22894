#include "starts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "trilateration.h"
#include "vir/core/angles.h"
#include "vir/team/closed_form.h"

namespace vir::team {
namespace {

constexpr int kYaws = 72;              // of a scan: 5 deg apart
constexpr std::size_t kFewRanges = 4;  // for these the closed form needs no scan
constexpr std::size_t kMostStarts = 8;

struct Scored {
  double cost;
  Vec4 x;
};

std::vector<Vec4> best(std::vector<Scored> list) {
  std::stable_sort(list.begin(), list.end(),
                   [](const Scored& a, const Scored& b) { return a.cost < b.cost; });
  std::vector<Vec4> out;
  for (std::size_t i = 0; i < list.size() && i < kMostStarts; ++i) out.push_back(list[i].x);
  return out;
}

/// Those of a closed ring of yaws that are better than both neighbours.
void addMinima(const std::vector<Scored>& ring, std::vector<Scored>* out) {
  const std::size_t n = ring.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double before = ring[(i + n - 1) % n].cost, after = ring[(i + 1) % n].cost;
    if (ring[i].cost <= before && ring[i].cost < after) out->push_back(ring[i]);
  }
}

}  // namespace

std::vector<MutualRange> thinned(const std::vector<MutualRange>& ranges, int most) {
  const std::size_t n = ranges.size(), m = static_cast<std::size_t>(std::max(most, 2));
  if (n <= m) return ranges;
  std::vector<MutualRange> out;
  out.reserve(m);
  for (std::size_t i = 0; i < m; ++i) out.push_back(ranges[i * (n - 1) / (m - 1)]);
  return out;
}

std::vector<Vec4> startsThroughAnchors(const EvidenceCost& cost) {
  std::vector<Scored> found;
  const auto score = [&](const WorldTransform& T) {
    const Vec4 x = toVector(T);
    return Scored{cost(x), x};
  };
  const std::size_t n = cost.size();
  for (const SharedAnchor& anchor : cost.anchors()) {
    const std::size_t step = std::max<std::size_t>(1, n / kFewRanges);
    for (std::size_t k = 0; k < n; k += step) {
      const YawPair pair = yawsFromRange(cost.ranges()[k], anchor);
      if (pair.problem != YawProblem::none) continue;
      for (const double yaw : pair.yaw_rad) found.push_back(score(throughAnchor(yaw, anchor)));
    }
    if (n <= kFewRanges && !found.empty()) continue;
    std::vector<Scored> ring;
    for (int i = 0; i < kYaws; ++i) {
      ring.push_back(score(throughAnchor(2 * kPi * i / kYaws - kPi, anchor)));
    }
    addMinima(ring, &found);
  }
  return best(found);
}

std::vector<Vec4> startsFromRanges(const EvidenceCost& cost) {
  std::vector<Scored> found;
  const Trilateration trilateration(cost.ranges());
  std::vector<std::vector<Scored>> rings(Trilateration::kBranches);
  for (int i = 0; i < kYaws; ++i) {
    const double yaw = 2 * kPi * i / kYaws - kPi;
    const auto offsets = trilateration.solve(yaw);
    for (std::size_t b = 0; b < offsets.size(); ++b) {
      Scored here{std::numeric_limits<double>::infinity(), Vec4::Zero()};
      if (offsets[b]) {
        here.x = toVector({yaw, *offsets[b]});
        here.cost = cost(here.x);
      }
      rings[b].push_back(here);
    }
  }
  for (const auto& ring : rings) addMinima(ring, &found);
  return best(found);
}

}  // namespace vir::team
