#include <algorithm>
#include <cmath>
#include <cstddef>

#include "window_state.h"

namespace vir::window {
namespace {

/// Parallax between two cameras from which on it tells a distance, in sigma_px.
constexpr double kAtOnceSigmas = 4;

/// Inverse distance along the host's ray that fits the other sights best (linear least squares);
/// false without parallax, behind a camera, or where the sights contradict each other.
bool triangulate(const WindowState& w, const WindowLandmark& l, double* rho) {
  const Pose T_B_Ci = w.T_B_C(l.hostCamera());
  const Pose T_W_Ci = l.host()->T_W_B() * T_B_Ci;
  const factors::CameraVector camera = w.cameraVector(l.hostCamera());
  double cc = 0, ca = 0, parallax = 0;
  // What two cameras see at once is known whatever the poses are.
  bool at_once = false;
  for (std::size_t k = 1; k < l.sights.size(); ++k) {
    const int number = l.sights[k].camera;
    const Pose T_Cj_Ci = (l.sights[k].frame->T_W_B() * w.T_B_C(number)).inverse() * T_W_Ci;
    const factors::Sight& s = l.sights[k].sight;
    const Vec3 a = T_Cj_Ci.q * l.ray.bearingAt(camera);
    const Vec3 seen = s.bearingAt(w.cameraVector(number));
    const Mat23& W = s.weight;
    const Vec2 Wa = W * (a - seen);
    const Vec2 Wc = W * T_Cj_Ci.p;
    cc += Wc.squaredNorm();
    ca += Wc.dot(Wa);
    at_once = at_once || l.sights[k].frame == l.host();
    const double angle = std::acos(std::clamp(a.dot(seen), -1.0, 1.0));
    parallax = std::max(parallax, angle);
  }
  const double least_px =
      at_once ? std::min(kAtOnceSigmas * w.options.sigma_px, w.options.min_parallax_px)
              : w.options.min_parallax_px;
  if (parallax * w.focalPx() < least_px || cc <= 0) return false;
  *rho = -ca / cc;
  if (!(*rho > 1.0 / 200.0 && *rho < 1.0 / 0.1)) return false;
  double worst = 0;
  for (std::size_t k = 1; k < l.sights.size(); ++k) {
    const LandmarkSight& s = l.sights[k];
    const factors::SightGeometry between(l.host()->T_W_B(), s.frame->T_W_B(), T_B_Ci,
                                         w.T_B_C(s.camera));
    const Vec2 r = sightResidual(w, l, s, between, Vec3(0, 0, *rho));
    worst = std::max(worst, r.norm());
  }
  return worst < 3 * w.options.outlier_sigma;
}

/// Of each two frames and cameras once it is asked for.
class GeometryTable {
 public:
  explicit GeometryTable(const WindowState& w)
      : cameras_(static_cast<std::size_t>(w.cameras())),
        views_(w.frames.size() * cameras_),
        known_(views_ * views_),
        table_(views_ * views_) {
    for (int k = 0; k < w.cameras(); ++k) T_B_C_.push_back(w.T_B_C(k));
    std::size_t k = 0;
    for (const auto& f : w.frames) f->index = k++;
  }
  const factors::SightGeometry& of(const WindowLandmark& l, const LandmarkSight& s) {
    const auto host = static_cast<std::size_t>(l.hostCamera());
    const auto other = static_cast<std::size_t>(s.camera);
    const std::size_t at =
        (l.host()->index * cameras_ + host) * views_ + s.frame->index * cameras_ + other;
    if (!known_[at]) {
      table_[at] =
          factors::SightGeometry(l.host()->T_W_B(), s.frame->T_W_B(), T_B_C_[host], T_B_C_[other]);
      known_[at] = true;
    }
    return table_[at];
  }

 private:
  std::size_t cameras_, views_;
  std::vector<Pose> T_B_C_;
  std::vector<bool> known_;
  std::vector<factors::SightGeometry> table_;
};

/// The landmark, which was at `p_W`, from the host it has now.
void hostAnew(const WindowState& w, const Vec3& p_W, WindowLandmark* l) {
  l->setHostRay();
  if (!l->has_depth) return;
  const Vec3 p_C = (l->host()->T_W_B() * w.T_B_C(l->hostCamera())).inverse() * p_W;
  // From p_C = (ray + basis (u, v)) / rho, along the bearing and across it.
  const Vec3 ray = l->ray.bearingAt(w.cameraVector(l->hostCamera()));
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
  const int camera = l.hostCamera();
  return l.host()->T_W_B() * (w.T_B_C(camera) * l.inCamera(w.cameraVector(camera)));
}

void updateCameraJacobians(const WindowState& w, WindowLandmark* l) {
  int number = l->hostCamera();  // whose they are
  Pose T_B_C = w.T_B_C(number);
  Mat3 R_C_B = T_B_C.R().transpose();
  factors::CameraVector camera = w.cameraVector(number);
  const Vec3 p_W = landmarkInWorld(w, *l);
  for (LandmarkSight& s : l->sights) {
    if (s.camera != number) {
      number = s.camera;
      T_B_C = w.T_B_C(number);
      R_C_B = T_B_C.R().transpose();
      camera = w.cameraVector(number);
    }
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
    s.setPlace(place, w.responseOf(number).at(place));
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
      const Vec2 r = sightResidual(w, l, l.sights[k], geometry.of(l, l.sights[k]), x);
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
    const auto of_frame = [&](const LandmarkSight& x) { return x.frame == frame; };
    const auto s = std::find_if(l.sights.begin(), l.sights.end(), of_frame);
    if (s == l.sights.end()) {
      ++it;
      continue;
    }
    const auto end = std::find_if_not(s, l.sights.end(), of_frame);  // they are neighbours
    const bool was_host = s == l.sights.begin();
    if (was_host && end == l.sights.end()) {
      it = w.landmarks.erase(it);
      continue;
    }
    const Vec3 p_W = was_host && l.has_depth ? landmarkInWorld(w, l) : Vec3::Zero();
    l.sights.erase(s, end);
    if (was_host) hostAnew(w, p_W, &l);
    ++it;
  }
}

}  // namespace vir::window
