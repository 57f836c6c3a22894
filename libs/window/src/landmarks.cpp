#include <algorithm>
#include <cmath>
#include <cstddef>

#include "window_state.h"

namespace vir::window {
namespace {

/// Inverse distance along the host's ray that fits the other sights best (linear least squares);
/// false without parallax, behind a camera, or where the sights contradict each other.
bool triangulate(const WindowState& w, const WindowLandmark& l, double* rho) {
  const Pose T_B_C = w.T_B_C();
  const Pose T_W_Ci = l.host()->T_W_B() * T_B_C;
  const factors::CameraVector camera = w.cameraVector();
  double cc = 0, ca = 0, parallax = 0;
  for (std::size_t k = 1; k < l.sights.size(); ++k) {
    const Pose T_Cj_Ci = (l.sights[k].frame->T_W_B() * T_B_C).inverse() * T_W_Ci;
    const factors::Sight& s = l.sights[k].sight;
    const Vec3 a = T_Cj_Ci.q * l.ray.bearingAt(camera);
    const Vec3 seen = s.bearingAt(camera);
    const Mat23& W = s.weight;
    const Vec2 Wa = W * (a - seen);
    const Vec2 Wc = W * T_Cj_Ci.p;
    cc += Wc.squaredNorm();
    ca += Wc.dot(Wa);
    const double angle = std::acos(std::clamp(a.dot(seen), -1.0, 1.0));
    parallax = std::max(parallax, angle);
  }
  if (parallax * w.focalPx() < w.options.min_parallax_px || cc <= 0) return false;
  *rho = -ca / cc;
  if (!(*rho > 1.0 / 200.0 && *rho < 1.0 / 0.1)) return false;
  double worst = 0;
  for (std::size_t k = 1; k < l.sights.size(); ++k) {
    const Vec2 r = factors::reprojectionResidual(l.ray, l.sights[k].sight, l.host()->T_W_B(),
                                                 l.sights[k].frame->T_W_B(), T_B_C,
                                                 Vec3(0, 0, *rho), camera, nullptr);
    worst = std::max(worst, r.norm());
  }
  return worst < 3 * w.options.outlier_sigma;
}

/// Of each two frames once it is asked for.
class GeometryTable {
 public:
  explicit GeometryTable(const WindowState& w)
      : T_B_C_(w.T_B_C()),
        frames_(w.frames.size()),
        known_(frames_ * frames_),
        table_(frames_ * frames_) {
    std::size_t k = 0;
    for (const auto& f : w.frames) f->index = k++;
  }
  const factors::SightGeometry& of(const Frame& host, const Frame& frame) {
    const std::size_t at = host.index * frames_ + frame.index;
    if (!known_[at]) {
      table_[at] = factors::SightGeometry(host.T_W_B(), frame.T_W_B(), T_B_C_);
      known_[at] = true;
    }
    return table_[at];
  }

 private:
  Pose T_B_C_;
  std::size_t frames_;
  std::vector<bool> known_;
  std::vector<factors::SightGeometry> table_;
};

/// The landmark, which was at `p_W`, from the host it has now.
void hostAnew(const WindowState& w, const Vec3& p_W, WindowLandmark* l) {
  l->setHostRay();
  if (!l->has_depth) return;
  const Vec3 p_C = (l->host()->T_W_B() * w.T_B_C()).inverse() * p_W;
  // From p_C = (ray + basis (u, v)) / rho, along the bearing and across it.
  const Vec3 ray = l->ray.bearingAt(w.cameraVector());
  const double along = p_C.dot(l->ray.bearing) / ray.dot(l->ray.bearing);
  l->has_depth = along > 0.05;
  if (!l->has_depth) return;
  const Vec2 uv = l->ray.basis.transpose() * (p_C / along - ray);
  l->x[0] = uv[0];
  l->x[1] = uv[1];
  l->x[2] = 1.0 / along;
}

}  // namespace

Vec3 landmarkInWorld(const WindowState& w, const WindowLandmark& l) {
  return l.host()->T_W_B() * (w.T_B_C() * l.inCamera(w.cameraVector()));
}

void updateCameraJacobians(const WindowState& w, WindowLandmark* l) {
  const Pose T_B_C = w.T_B_C();
  const Mat3 R_C_B = T_B_C.R().transpose();
  const factors::CameraVector camera = w.cameraVector();
  const Vec3 p_W = landmarkInWorld(w, *l);
  for (LandmarkSight& s : l->sights) {
    const Frame& f = *s.frame;
    const Mat3& R_B_W = f.R_B_W;
    const Vec3 v_W(f.speed_bias[0], f.speed_bias[1], f.speed_bias[2]);
    const Vec3 p_B = R_B_W * (p_W - Vec3(f.pose[0], f.pose[1], f.pose[2]));
    const Vec3 p_C = R_C_B * (p_B - T_B_C.p);
    const double distance = p_C.norm();
    if (distance < 0.05) continue;
    const Vec3 b = p_C / distance;
    // A fixed point as the body sees it move, and how its direction from the camera changes.
    const Vec3 v_C = R_C_B * (-f.rate.cross(p_B) - R_B_W * v_W);
    const Vec2 residual = s.sight.weight * (b - s.sight.bearingAt(camera)) * w.options.sigma_px;
    s.setRate((v_C - b * b.dot(v_C)) / distance);
    const Vec2 place = s.off_centre + residual;
    s.setPlace(place, w.radial_response.at(place));
  }
  l->ray.by_camera = l->sights.front().sight.by_camera;
}

void noteRotations(WindowState& w) {
  for (const auto& f : w.frames) f->R_B_W = f->T_W_B().R().transpose();
}

int triangulateLandmarks(WindowState& w) {
  int count = 0;
  for (auto& [id, l] : w.landmarks) {
    if (l.has_depth || l.sights.size() < 2) continue;
    double rho = 0;
    if (!triangulate(w, l, &rho)) continue;
    l.x[0] = l.x[1] = 0;
    l.x[2] = rho;
    l.has_depth = l.unchecked = true;
    ++count;
  }
  return count;
}

std::vector<std::uint64_t> rejectOutlierSights(WindowState& w) {
  std::vector<std::uint64_t> removed;
  const Frame* newest = w.frames.back().get();
  const factors::CameraVector camera = w.cameraVector();
  GeometryTable geometry(w);
  for (auto it = w.landmarks.begin(); it != w.landmarks.end();) {
    WindowLandmark& l = it->second;
    if (!l.has_depth) {
      ++it;
      continue;
    }
    const Vec3 x(l.x[0], l.x[1], l.x[2]);
    bool newest_bad = false;
    std::size_t bad = 0, k = 1;
    if (!l.unchecked && l.host()->index < w.moved_from) {
      k = l.sights.size();
      while (k > 1 && l.sights[k - 1].frame->index >= w.moved_from) --k;
    }
    l.unchecked = false;
    while (k < l.sights.size()) {
      const Vec2 r = factors::reprojectionResidual(
          l.ray, l.sights[k].sight, geometry.of(*l.host(), *l.sights[k].frame), x, camera, nullptr);
      if (r.norm() > w.options.outlier_sigma) {
        newest_bad = newest_bad || l.sights[k].frame == newest;
        l.sights.erase(l.sights.begin() + static_cast<std::ptrdiff_t>(k));
        ++bad;
      } else {
        ++k;
      }
    }
    const bool impossible = !(l.x[2] > 1e-4 && l.x[2] < 1.0 / 0.05);
    if (impossible || newest_bad || (bad > 0 && l.sights.size() < 2)) {
      removed.push_back(it->first);
      it = w.landmarks.erase(it);
    } else {
      ++it;
    }
  }
  w.moved_from = w.frames.size();
  return removed;
}

void removeSightsOf(WindowState& w, const Frame* frame) {
  for (auto it = w.landmarks.begin(); it != w.landmarks.end();) {
    WindowLandmark& l = it->second;
    const auto s = std::find_if(l.sights.begin(), l.sights.end(),
                                [&](const LandmarkSight& x) { return x.frame == frame; });
    if (s == l.sights.end()) {
      ++it;
      continue;
    }
    const bool was_host = s == l.sights.begin();
    if (l.sights.size() == 1) {
      it = w.landmarks.erase(it);
      continue;
    }
    const Vec3 p_W = was_host && l.has_depth ? landmarkInWorld(w, l) : Vec3::Zero();
    l.sights.erase(s);
    if (was_host) hostAnew(w, p_W, &l);
    ++it;
  }
}

}  // namespace vir::window
