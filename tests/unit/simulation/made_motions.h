#pragma once
/// Motions for the simulator's tests.
#include <cmath>
#include <memory>

#include "vir/simulation/flights.h"

namespace vir_test {

/// A brisk flight of about a minute.
inline std::shared_ptr<const vir::simulation::Motion> briskFlight() {
  vir::simulation::FlightOptions o;
  o.length_m = 80;
  return std::make_shared<vir::simulation::Motion>(vir::simulation::flight("eight", o));
}

inline std::shared_ptr<const vir::simulation::Motion> standing(double seconds) {
  vir::Trajectory poses;
  const vir::Quat q = vir::expQuat(vir::Vec3(0.1, -0.2, 0.7));
  for (int k = 0; k <= static_cast<int>(std::lround(seconds)); ++k) {
    poses.push_back({1000000000LL * (k + 1), {q, vir::Vec3(1, 2, 3)}});
  }
  return std::make_shared<vir::simulation::Motion>(poses.front().t, 1.0, poses);
}

}  // namespace vir_test
