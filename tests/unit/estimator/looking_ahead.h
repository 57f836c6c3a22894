#pragma once
/// Flights for tests of the whole estimator on simulated tracks.
#include <memory>
#include <string>

#include "simulated_run.h"
#include "vir/simulation/flights.h"

namespace vir_test {

/// 640x480, looking along body x; no ranges.
inline vir::tool::RunSettings lookingAhead() {
  vir::tool::RunSettings s;
  s.camera.width = 640;
  s.camera.height = 480;
  s.camera.fx = s.camera.fy = 400;
  s.camera.cx = 320;
  s.camera.cy = 240;
  vir::Mat3 R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  s.T_B_C = {vir::Quat(R), vir::Vec3(0.05, 0.02, -0.01)};
  return s;
}

inline std::shared_ptr<const vir::simulation::Motion> flightOf(const std::string& name,
                                                               double length_m) {
  vir::simulation::FlightOptions o;
  o.length_m = length_m;
  return std::make_shared<vir::simulation::Motion>(vir::simulation::flight(name, o));
}

}  // namespace vir_test
