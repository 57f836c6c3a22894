#include "vir/window/short_window.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "vir/geometry/so3.h"
#include "window_state.h"

namespace vir::window {
namespace {

/// Those wanted of all that frames hold, antenna and lever arm in O.
template <typename Wanted>
std::vector<HeldRange> heldInO(const WindowState& w, const Wanted& wanted) {
  std::vector<HeldRange> out;
  for (const auto& f : w.frames) {
    const Pose T_O_B = f->T_W_B();
    for (HeldRange r : f->ranges) {
      if (!wanted(r)) continue;
      r.motion = T_O_B * Vec3(r.motion + r.lever);
      r.lever = T_O_B.q * r.lever;
      out.push_back(r);
    }
  }
  return out;
}

}  // namespace
struct ShortWindow::Impl : WindowState {
  Frame& add(const State& s, const std::vector<vision::FeatureObservation>& features,
             bool standing) {
    auto f = std::make_unique<Frame>();
    f->t = s.t;
    factors::poseTo(s.T_W_B, f->pose);
    for (int i = 0; i < 3; ++i) {
      f->speed_bias[i] = s.v[i];
      f->speed_bias[3 + i] = s.bg[i];
      f->speed_bias[6 + i] = s.ba[i];
    }
    f->standing = standing;
    frames.push_back(std::move(f));
    information_known = false;
    for (const vision::FeatureObservation& o : features) {
      WindowLandmark& l = landmarks[o.id];
      l.sights.push_back(sightOf(o));
      if (l.sights.size() == 1) {
        l.setHostRay();
        continue;
      }
      // A new track has no rate yet: the camera's next image tells how it was moving.
      const auto of_camera = [&o](const LandmarkSight& x) { return x.camera == o.camera; };
      const auto first = std::find_if(l.sights.begin(), l.sights.end(), of_camera);
      if (first->hasRate() ||
          std::find_if(first + 1, l.sights.end(), of_camera) + 1 != l.sights.end())
        continue;
      first->setRate(o.bearing_rate);
      if (first == l.sights.begin()) l.setHostRay();
    }
    return *frames.back();
  }
};

ShortWindow::ShortWindow(const WindowOptions& options, const imu::ImuNoise& noise,
                         const Calibration& calibration)
    : impl_(std::make_unique<Impl>()) {
  impl_->options = options;
  impl_->noise = noise;
  impl_->calibration_sigma = options.calibration;
  impl_->camera_parameters[factors::kReadout] = options.readout_s;
  impl_->shutter_decided = options.readout_s > 0;
  impl_->lens_held = options.lens != LensMode::free;
  setCalibration(calibration);
}

ShortWindow::~ShortWindow() = default;

void ShortWindow::clear() {
  impl_->frames.clear();
  impl_->landmarks.clear();
  impl_->prior = factors::LinearPrior();
  impl_->prior_blocks.clear();
  impl_->information_known = false;
  impl_->moved_from = 0;
}

bool ShortWindow::empty() const { return impl_->frames.empty(); }
int ShortWindow::frames() const { return static_cast<int>(impl_->frames.size()); }

void ShortWindow::start(const State& state, const StartPrior& p,
                        const std::vector<vision::FeatureObservation>& features, bool standing) {
  clear();
  Frame& f = impl_->add(state, features, standing);
  f.keyframe = true;
  std::vector<Eigen::Matrix<double, 1, 15>> rows;
  const auto row = [&](int column, const Vec3& direction, double sigma) {
    if (sigma <= 0) return;
    Eigen::Matrix<double, 1, 15> r = Eigen::Matrix<double, 1, 15>::Zero();
    r.segment<3>(column) = direction.transpose() / sigma;
    rows.push_back(r);
  };
  const Mat3 R_B_W = f.T_W_B().R().transpose();
  for (int i = 0; i < 3; ++i) {
    row(0, Vec3::Unit(i), p.position_m);
    row(3, R_B_W.col(i), i == 2 ? p.yaw_rad : p.tilt_rad);
    row(6, Vec3::Unit(i), p.velocity_mps);
    row(9, Vec3::Unit(i), p.bias_gyro);
    row(12, Vec3::Unit(i), p.bias_acc);
  }
  factors::LinearPrior& prior = impl_->prior;
  const int n = static_cast<int>(rows.size());
  prior.J = Eigen::MatrixXd::Zero(n, 15);
  for (int k = 0; k < n; ++k) prior.J.row(k) = rows[static_cast<std::size_t>(k)];
  prior.blocks = {{7, 0, std::vector<double>(f.pose, f.pose + 7)},
                  {9, 6, std::vector<double>(f.speed_bias, f.speed_bias + 9)}};
  impl_->prior_blocks = {f.pose, f.speed_bias};
  addCalibrationPrior(*impl_);
  prior.r0 = Eigen::VectorXd::Zero(prior.J.rows());
}

void ShortWindow::push(const State& predicted, imu::Preintegration link,
                       const std::vector<vision::FeatureObservation>& features, bool standing) {
  if (!impl_->newest().keyframe && impl_->frames.size() > 1) dropNewestInto(*impl_, &link);
  Frame& before = impl_->newest();
  if (!before.link) before.rate = link.firstRate();
  Frame& f = impl_->add(predicted, features, standing);
  f.rate = link.lastRate();
  f.link = std::make_unique<imu::Preintegration>(std::move(link));
}

Resected ShortWindow::resect(const Pose& predicted,
                             const std::vector<vision::FeatureObservation>& features,
                             double far_px) const {
  return window::resect(*impl_, predicted, features, far_px);
}

void ShortWindow::keepNewest() { impl_->newest().keyframe = true; }

int ShortWindow::triangulate() { return triangulateLandmarks(*impl_); }

SolveSummary ShortWindow::optimise(int iterations) { return solveWindow(*impl_, iterations); }

SolveSummary ShortWindow::optimiseNewest(int iterations) {
  const int n = frames();
  return solveTail(
      *impl_, iterations,
      static_cast<std::size_t>(std::max(n > 1 ? 1 : 0, n - impl_->options.newest_frames)));
}

bool ShortWindow::newestIsKeyframe() const { return decideKeyframe(*impl_); }
bool ShortWindow::newestEndsRestLink() const { return endsRestLink(*impl_); }

std::vector<std::uint64_t> ShortWindow::rejectOutliers() { return rejectOutlierSights(*impl_); }

void ShortWindow::slide(bool keyframe) {
  impl_->newest().keyframe = keyframe;
  impl_->information_known = false;
  // Tracks that ended without ever getting a depth, or outside the window, are of no more use.
  const Frame* newest = impl_->frames.back().get();
  for (auto it = impl_->landmarks.begin(); it != impl_->landmarks.end();) {
    const WindowLandmark& l = it->second;
    const bool ended = l.sights.back().frame != newest;
    it =
        ended && (l.sights.size() < 2 || !l.has_depth) ? impl_->landmarks.erase(it) : std::next(it);
  }
  if (!keyframe) return;
  if (static_cast<int>(impl_->frames.size()) > impl_->options.keyframes) marginalizeOldest(*impl_);
}

State ShortWindow::newest() const { return navStateOf(*impl_->frames.back()); }
State ShortWindow::oldest() const { return navStateOf(*impl_->frames.front()); }

std::vector<State> ShortWindow::states() const {
  std::vector<State> out;
  for (const auto& f : impl_->frames) out.push_back(navStateOf(*f));
  return out;
}

std::vector<Landmark> ShortWindow::landmarks() const {
  std::vector<Landmark> out;
  for (const auto& [id, l] : impl_->landmarks) {
    if (l.has_depth) out.push_back({id, landmarkInWorld(*impl_, l)});
  }
  return out;
}

int ShortWindow::landmarksInNewest() const {
  int n = 0;
  for (const auto& [id, l] : impl_->landmarks) {
    n += l.has_depth && l.sights.back().frame == impl_->frames.back().get();
  }
  return n;
}

std::vector<LandmarkDistance> ShortWindow::distancesInNewest() const {
  std::vector<LandmarkDistance> out;
  const Frame* newest = impl_->frames.back().get();
  const Vec3 p_C = newest->T_W_B() * impl_->T_B_C().p;
  for (const auto& [id, l] : impl_->landmarks) {
    if (!l.has_depth || l.sights.back().frame != newest) continue;
    const Vec3 ray = landmarkInWorld(*impl_, l) - p_C;
    double information = 0;  // of the inverse distance, by how far another one moves the sights
    for (const LandmarkSight& s : l.sights) {
      const Vec3 way = s.frame->T_W_B() * impl_->T_B_C(s.camera).p - p_C;
      const double moves_px = impl_->focalPx() * way.cross(ray.normalized()).norm();
      information += std::pow(moves_px / impl_->options.sigma_px, 2);
    }
    if (information > 0) out.push_back({id, 1 / ray.norm(), 1 / std::sqrt(information)});
  }
  return out;
}

void ShortWindow::moveAllToLongWindow() {
  if (!impl_->long_window || impl_->long_window->empty()) return;
  while (impl_->frames.size() > 1) {
    handToLongWindow(*impl_);
    impl_->frames.pop_front();
  }
}

std::vector<Landmark> ShortWindow::takeRetiredLandmarks() {
  return std::exchange(impl_->retired_landmarks, {});
}

WindowAccuracy ShortWindow::accuracy() const {
  WindowAccuracy out;
  const std::size_t n = impl_->frames.size();
  if (n < 2) return out;
  NormalEquations information = informationOf(*impl_);
  holdLens(*impl_, &information);
  const Eigen::MatrixXd cov = covarianceOf(information);
  std::size_t a = 0, b = 1;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      const double d = (impl_->frames[j]->T_W_B().p - impl_->frames[i]->T_W_B().p).norm();
      if (d > out.baseline_m) {
        out.baseline_m = d;
        a = i;
        b = j;
      }
    }
  }
  if (out.baseline_m <= 0) return out;
  Eigen::VectorXd u = Eigen::VectorXd::Zero(cov.rows());
  const Vec3 dir = (impl_->frames[b]->T_W_B().p - impl_->frames[a]->T_W_B().p).normalized();
  u.segment<3>(6 * static_cast<int>(b)) = dir;
  u.segment<3>(6 * static_cast<int>(a)) = -dir;
  out.baseline_sigma_m = std::sqrt(std::max(0.0, u.dot(cov * u)));
  const int last = 6 * static_cast<int>(n - 1);
  const Mat3 R = impl_->frames.back()->T_W_B().R();
  const Mat3 tilt = R * cov.block<3, 3>(last + 3, last + 3) * R.transpose();
  out.tilt_sigma_rad = std::sqrt(std::max(0.0, std::max(tilt(0, 0), tilt(1, 1))));
  return out;
}

void ShortWindow::attach(LongWindow* long_window) { impl_->long_window = long_window; }

void ShortWindow::addRange(const HeldRange& range) { impl_->newest().ranges.push_back(range); }

std::vector<HeldRange> ShortWindow::rangesInO(std::uint64_t anchor) const {
  return heldInO(*impl_,
                 [anchor](const HeldRange& r) { return r.anchor == anchor && !r.reference; });
}

std::vector<HeldRange> ShortWindow::differencesInO() const {
  return heldInO(*impl_, [](const HeldRange& r) { return r.reference.has_value(); });
}

std::vector<HeldRange> ShortWindow::rangesAtOldest() const {
  std::vector<HeldRange> out;
  const Vec3 origin = impl_->frames.front()->T_W_B().p;
  for (const auto& f : impl_->frames) {
    const Pose T_O_B = f->T_W_B();
    for (HeldRange r : f->ranges) {
      r.motion = T_O_B * r.motion - origin;
      r.lever = T_O_B.q * r.lever;
      out.push_back(r);
    }
  }
  return out;
}

void ShortWindow::updateCovariance() {
  window::updateCovariance(*impl_);
  decideShutter(*impl_);
  watchLens(*impl_);
}

Eigen::Matrix<double, 6, 6> ShortWindow::newestCovariance() const {
  return impl_->covariance.newest;
}

Pose ShortWindow::extrinsics() const { return impl_->T_B_C(); }
imu::ImuIntrinsics ShortWindow::imuIntrinsics() const { return impl_->imuIntrinsics(); }
double ShortWindow::timeOffset() const { return impl_->camera_parameters[factors::kTimeOffset]; }

void ShortWindow::setTimeOffset(double time_offset_s, double sigma_s) {
  impl_->calibration_sigma.time_offset_s = sigma_s;
  impl_->camera_parameters[factors::kTimeOffset] = time_offset_s;
  impl_->stamp_offset_s = time_offset_s;
  for (FurtherCamera& c : impl_->further) {
    c.parameters[factors::kTimeOffset] = time_offset_s + c.offset_to_first_s;
  }
}

void ShortWindow::setRigMisfit(double px) {
  for (FurtherCamera& c : impl_->further) c.sigma = rigSigma(*impl_, c, px);
}

void ShortWindow::setCalibration(const Calibration& calibration) {
  takeCalibration(*impl_, calibration);
}

void ShortWindow::setExtrinsicsSigma(double position_m, double rotation_rad) {
  CalibrationSigma& s = impl_->calibration_sigma;
  s.position_m = std::max(impl_->options.calibration.position_m, position_m);
  s.rotation_rad = std::max(impl_->options.calibration.rotation_rad, rotation_rad);
}

CalibrationSigma ShortWindow::calibrationSigma() const {
  if (!impl_->covariance.calibration) return impl_->calibration_sigma;
  return sigmaOf(impl_->covariance.calibration->diagonal().cwiseMax(0).cwiseSqrt());
}

std::vector<CalibrationSigma> ShortWindow::furtherSigma() const {
  return impl_->covariance.further;
}

std::vector<RigDistance> ShortWindow::rigDistances() const {
  const std::vector<double>& sigmas = impl_->covariance.distance_sigma_m;
  std::vector<RigDistance> out;
  for (std::size_t k = 0; k < sigmas.size(); ++k) {
    out.push_back({impl_->further[k].sigma.position_m, sigmas[k]});
  }
  return out;
}

std::optional<CalibrationCovariance> ShortWindow::calibrationCovariance() const {
  return impl_->covariance.calibration;
}

bool ShortWindow::lensContradicted() const {
  return impl_->options.lens == LensMode::watched && !impl_->lens_held;
}

void ShortWindow::stampWith(double time_offset_s) { impl_->stamp_offset_s = time_offset_s; }
void ShortWindow::setStampSigma(double sigma_s) { impl_->stamp_sigma_s = sigma_s; }

Calibration ShortWindow::calibration() const { return calibrationOf(*impl_); }

}  // namespace vir::window
