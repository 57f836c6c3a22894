#pragma once
/// Aisles between shelves that are all alike, and a robot that goes round them several times.
#include <cmath>
#include <memory>
#include <vector>

#include "rendered_places.h"
#include "vir/core/angles.h"
#include "vir/core/random.h"
#include "vir/places/verify_loop.h"
#include "vir/rendering/scene.h"

namespace vir_test {

struct AisleOptions {
  int aisles = 4, bays = 5;
  double bay_m = 3.2, aisle_m = 2.4, shelf_m = 0.9, height_m = 2.6;
  int unique_per_bay = 0;  ///< crates of their own; 0: nothing tells one bay from another
  int seed = 1;
};

/// Every bay, on either side: two uprights, three boards, goods on them; tiles on the floor.
inline std::shared_ptr<const vir::rendering::Scene> aisles(const AisleOptions& o) {
  using vir::Vec3;
  std::vector<vir::rendering::Box> boxes;
  const auto add = [&](const Vec3& low, const Vec3& size, int look) {
    boxes.push_back({low, low + size, look});
  };
  vir::Random alike(static_cast<std::uint64_t>(o.seed), 1),
      own(static_cast<std::uint64_t>(o.seed), 2);
  struct Goods {
    Vec3 at, size;
  };
  std::vector<Goods> goods;
  for (int board = 0; board < 3; ++board) {
    for (int k = 0; k < 4; ++k) {
      goods.push_back(
          {Vec3(0.1 + 0.75 * k + alike.uniform(0, 0.2), alike.uniform(0, 0.3), 0.08 + 0.85 * board),
           Vec3(alike.uniform(0.25, 0.5), alike.uniform(0.3, 0.5), alike.uniform(0.25, 0.6))});
    }
  }
  for (int row = 0; row <= o.aisles; ++row) {
    const double y = row * (o.aisle_m + o.shelf_m) - 0.5 * o.aisle_m - o.shelf_m;
    for (int bay = 0; bay < o.bays; ++bay) {
      const Vec3 c(bay * o.bay_m, y, 0);
      add(c + Vec3(0, 0.02, 0.02), Vec3(0.06, o.shelf_m - 0.04, o.height_m - 0.1), 0);
      for (int board = 0; board < 3; ++board) {
        add(c + Vec3(0.06, 0.02, 0.03 + 0.85 * board), Vec3(o.bay_m - 0.06, o.shelf_m - 0.04, 0.05),
            1);
      }
      int look = 10;
      for (const Goods& g : goods) add(c + g.at + Vec3(0, 0.05, 0), g.size, look++);
      for (int k = 0; k < o.unique_per_bay; ++k) {
        const bool near_side = own.uniform() < 0.5;
        const Vec3 at(own.uniform(0.2, o.bay_m - 0.6), near_side ? -0.12 : o.shelf_m + 0.02,
                      own.uniform(0, 2));
        add(c + at, Vec3(own.uniform(0.2, 0.5), 0.1, own.uniform(0.2, 0.5)), -1);
      }
      add(c + Vec3(0, o.shelf_m, -0.02), Vec3(o.bay_m, o.aisle_m, 0.03), 2);
    }
  }
  const double length = o.bays * o.bay_m, width = (o.aisles + 1) * (o.aisle_m + o.shelf_m);
  const vir::rendering::Box room{Vec3(-4, -4, 0), Vec3(length + 4, width + 2, o.height_m)};
  return std::make_shared<vir::rendering::Scene>(room, std::move(boxes));
}

/// Poses T_W_B every `step_m`: along each aisle and back, aisle after aisle, then again.
inline std::vector<vir::Pose> rounds(const AisleOptions& o, int times, double step_m) {
  using vir::Vec3;
  std::vector<vir::Pose> out;
  vir::Random sway(static_cast<std::uint64_t>(o.seed), 3);
  double side = 0, rise = 0;
  const auto put = [&](Vec3 p, double yaw) {
    side = 0.9 * side + 0.05 * sway.normal();
    rise = 0.9 * rise + 0.04 * sway.normal();
    p += Vec3(-std::sin(yaw), std::cos(yaw), 0) * side + Vec3(0, 0, rise);
    out.push_back(
        bodyAt(p, yaw + 0.03 * sway.normal(), 0.03 * sway.normal(), 0.03 * sway.normal()));
  };
  const double begin = -1.5, end = o.bays * o.bay_m + 1.5;
  for (int round = 0; round < times; ++round) {
    for (int k = 0; k < o.aisles; ++k) {
      const double y = k * (o.aisle_m + o.shelf_m);
      for (double x = begin; x < end; x += step_m) put(Vec3(x, y, 1.3), 0);
      for (double x = end; x > begin; x -= step_m) put(Vec3(x, y, 1.3), vir::kPi);
      for (double s = 0; s < o.aisle_m + o.shelf_m; s += step_m)
        put(Vec3(begin, y + s, 1.3), 0.5 * vir::kPi);
    }
    for (double s = o.aisles * (o.aisle_m + o.shelf_m); s > 0; s -= step_m) {
      put(Vec3(begin, s, 1.3), -0.5 * vir::kPi);
    }
  }
  return out;
}

/// A path that drifts, and what is known of it.
struct Drifting {
  std::vector<vir::Pose> poses;
  double share = 0.01;            ///< of the way (standard deviation, random walk per metre)
  double yaw_per_root_m = 0.001;  ///< [rad]
  std::vector<double> way;

  Drifting(const std::vector<vir::Pose>& truth, double drift, int seed) : share(drift) {
    yaw_per_root_m = 0.1 * drift;
    vir::Random random(static_cast<std::uint64_t>(seed), 4);
    vir::Pose at = truth.front();
    poses.push_back(at);
    way.push_back(0);
    double yaw = 0;
    for (std::size_t k = 1; k < truth.size(); ++k) {
      const vir::Vec3 step = truth[k].p - truth[k - 1].p;
      const double length = step.norm(), root = std::sqrt(length);
      yaw += yaw_per_root_m * root * random.normal();
      const vir::Vec3 noise =
          share * root * vir::Vec3(random.normal(), random.normal(), 0.3 * random.normal());
      at.p += vir::rotZ(yaw) * step + noise;
      at.q = vir::Quat(vir::rotZ(yaw)) * truth[k].q;
      poses.push_back(at);
      way.push_back(way.back() + length);
    }
  }
  /// Of keyframe b as seen from a.
  vir::places::RelativePrior between(std::size_t a, std::size_t b) const {
    vir::places::RelativePrior out;
    out.T_older_newer = poses[a].inverse() * poses[b];
    const double way_m = std::abs(way[b] - way[a]);
    const double turn = yaw_per_root_m * std::sqrt(way_m);
    // A heading that is off by so much all along the way, at most.
    const double swing = turn * std::min(way_m, 20.0) * 0.6;
    const double sigma = std::hypot(share * std::sqrt(way_m), swing) + 0.01;
    out.covariance.setZero();
    out.covariance.diagonal().head<3>().setConstant(sigma * sigma);
    out.covariance.diagonal().tail<3>().setConstant(turn * turn + 1e-5);
    return out;
  }
};

}  // namespace vir_test
