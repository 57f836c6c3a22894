#include "window_state.h"

#include <cmath>

#include "vir/window/short_window.h"

namespace vir::window {

State predict(const State& from, const imu::Preintegration& link, double gravity, TimeNs t) {
  const Vec3 g(0, 0, -gravity);
  const double dt = link.dt();
  State s = from;
  s.t = t;
  s.T_W_B.p += from.v * dt + 0.5 * g * dt * dt + from.T_W_B.q * link.correctedDp(from.bg, from.ba);
  s.v += g * dt + from.T_W_B.q * link.correctedDv(from.bg, from.ba);
  s.T_W_B.q = (from.T_W_B.q * link.correctedDq(from.bg)).normalized();
  return s;
}

State navStateOf(const Frame& f) {
  State s;
  s.t = f.t;
  s.T_W_B = f.T_W_B();
  s.v = Vec3(f.speed_bias[0], f.speed_bias[1], f.speed_bias[2]);
  s.bg = Vec3(f.speed_bias[3], f.speed_bias[4], f.speed_bias[5]);
  s.ba = Vec3(f.speed_bias[6], f.speed_bias[7], f.speed_bias[8]);
  return s;
}

/// All sights of an image are off by the same time, as noise of each alone is not: taken for that
/// much more than it is.
void WindowState::believeLessAlong(const Vec2& px_rate, Mat23* weight) const {
  constexpr double kInCommon = 3;
  const double speed = px_rate.norm();
  if (!(speed > 0)) return;
  const Vec2 way = px_rate / speed;
  const double off_px = kInCommon * stamp_sigma_s * speed;
  const double less = options.sigma_px / std::hypot(options.sigma_px, off_px);
  *weight += ((less - 1) * way) * (way.transpose() * *weight).eval();
}

LandmarkSight WindowState::sightOf(const vision::FeatureObservation& o) const {
  const CameraCalibration& c = cameraOf(o.camera);
  LandmarkSight s;
  s.frame = frames.back().get();
  s.camera = o.camera;
  s.row = c.height > 0 ? o.px.y() / c.height - 0.5 : 0;
  s.off_centre = o.px - Vec2(c.cx, c.cy);
  s.sight.bearing = o.bearing;
  s.sight.weight = o.dpx_dbearing / (o.noise * options.sigma_px);
  if (stamp_sigma_s > 0) believeLessAlong(o.dpx_dbearing * o.bearing_rate, &s.sight.weight);
  s.sight.by_camera =
      factors::bearingByCamera(o.px, o.dpx_dbearing, o.bearing_rate, Vec2(c.cx, c.cy), s.row,
                               responseOf(o.camera).at(s.off_centre));
  const double to_first = o.camera == 0 ? 0 : beside(o.camera).offset_to_first_s;
  s.sight.at[factors::kTimeOffset] = stamp_offset_s + to_first;
  return s;
}

Vec2 sightResidual(const WindowState& w, const WindowLandmark& l, const LandmarkSight& s,
                   const factors::SightGeometry& between, const Vec3& x) {
  return factors::rigResidual(l.ray, s.sight, between, x, w.cameraVector(l.hostCamera()),
                              w.cameraVector(s.camera), nullptr);
}

}  // namespace vir::window
