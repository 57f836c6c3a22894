#include "vir/rendering/scene.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace vir::rendering {
namespace {

constexpr std::size_t kMaxBoxes = 5000;
/// Lines that only touch a box do not enter it [m].
constexpr double kSkin_m = 1e-6;

void check(const Box& b, const std::string& name) {
  if (!b.low.allFinite() || !b.high.allFinite() || !((b.high - b.low).minCoeff() > 0)) {
    throw std::invalid_argument("Scene: " + name + " has no inside or is not finite");
  }
}

/// Share of the line from a to b, from .. to of 0..1, that lies in the box; `to` < `from` if none.
void cut(const Box& box, const Vec3& a, const Vec3& d, double* from, double* to) {
  *from = 0;
  *to = 1;
  for (int k = 0; k < 3; ++k) {
    if (std::abs(d[k]) < 1e-12) {
      if (a[k] <= box.low[k] || a[k] >= box.high[k]) *to = -1;
      continue;
    }
    const double s = (box.low[k] - a[k]) / d[k], e = (box.high[k] - a[k]) / d[k];
    *from = std::max(*from, std::min(s, e));
    *to = std::min(*to, std::max(s, e));
  }
}

}  // namespace

Scene::Scene(const Box& interior, std::vector<Box> boxes)
    : interior_(interior), boxes_(std::move(boxes)) {
  check(interior_, "the room");
  if (boxes_.size() > kMaxBoxes) {
    throw std::invalid_argument("Scene: " + std::to_string(boxes_.size()) + " boxes; at most " +
                                std::to_string(kMaxBoxes) + " are possible");
  }
  for (std::size_t k = 0; k < boxes_.size(); ++k) check(boxes_[k], "box " + std::to_string(k));
}

double Scene::solidBetween(const Vec3& a, const Vec3& b) const {
  const Vec3 d = b - a;
  const double length = d.norm();
  double sum = 0, from = 0, to = 0;
  for (const Box& box : boxes_) {
    cut(box, a, d, &from, &to);
    if (to > from && (to - from) * length > kSkin_m) sum += (to - from) * length;
  }
  return sum;
}

bool Scene::hidden(const Vec3& a, const Vec3& b) const {
  if (!interior_.holds(a, kSkin_m) || !interior_.holds(b, kSkin_m)) return true;
  const Vec3 d = b - a;
  const double length = d.norm();
  double from = 0, to = 0;
  return std::any_of(boxes_.begin(), boxes_.end(), [&](const Box& box) {
    cut(box, a, d, &from, &to);
    return to > from && (to - from) * length > kSkin_m;
  });
}

}  // namespace vir::rendering
