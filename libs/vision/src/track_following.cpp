#include <cmath>

#include "motion_filter.h"
#include "tracker_impl.h"

namespace vir::vision {

namespace {
// Tracks nearer to each other than this share of min_distance_px are thinned out.
constexpr double kCrowded = 0.5;
// A prediction by which this share of so many tracks is lost may be wrong, and is, if another finds
// so many times more.
constexpr double kNearlyAll = 0.7;
constexpr std::size_t kTracksThatCount = 20, kClearlyMore = 2;
}  // namespace

bool FeatureTracker::Impl::insideBorder(const Vec2& p) const {
  const CameraCalibration& c = camera->calibration();
  return p.x() >= border && p.y() >= border && p.x() <= c.width - 1 - border &&
         p.y() <= c.height - 1 - border;
}

bool FeatureTracker::Impl::observe(const Vec2& px, FeatureObservation* f) const {
  f->px = px;
  Vec2 again;
  return insideBorder(px) && camera->unproject(px, &f->bearing) &&
         camera->project(f->bearing, &again, &f->dpx_dbearing);
}

void FeatureTracker::Impl::predict(const Mat3& R_C0_C1, int* lost) {
  const CameraCalibration& c = camera->calibration();
  const Mat3 R_C1_C0 = R_C0_C1.transpose();
  followed.clear();
  start.clear();
  forward.clear();
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const FeatureObservation& seen = tracks[i].seen;
    Vec2 predicted;
    Mat23 J;
    if (!camera->project(R_C1_C0 * seen.bearing, &predicted, &J)) {
      ++*lost;
      continue;
    }
    // Translation may still bring it back inside: start at the rim.
    predicted.x() = std::clamp(predicted.x(), 0.0, c.width - 1.0);
    predicted.y() = std::clamp(predicted.y(), 0.0, c.height - 1.0);
    Followed f;
    f.from = i;
    // What the rotation does to the neighbourhood of the feature.
    const Mat23& J0 = seen.dpx_dbearing;
    f.warp.A = J * R_C1_C0 * J0.transpose() * (J0 * J0.transpose()).inverse();
    followed.push_back(f);
    start.push_back(toPoint(0.5 * seen.px));
    forward.push_back(toPoint(0.5 * predicted));
  }
}

bool FeatureTracker::Impl::align(const Track& track, const cv::Point2f& start_half,
                                 Followed* f) const {
  const AlignOptions align_options{options.max_iterations, 4.0, options.min_similarity};
  const Vec2 at = 2.0 * toVec(start_half);
  const Eigen::Matrix2d turn = f->warp.A;
  const auto startAt = [&](const Patch& patch, const Eigen::Matrix2d& A) {
    PatchWarp w{A, Vec2::Zero()};
    w.c = at - patch.feature(w);
    return w;
  };
  const double area = track.warp.A.determinant();
  if (area > 0.4 && area < 2.5) {
    f->warp = startAt(track.patch, turn * track.warp.A);
    if (track.patch.align(current.full(), align_options, &f->warp)) {
      return observe(track.patch.feature(f->warp), &f->now);
    }
  }
  // It does not look like the first sight of it any more: compare with the last one instead.
  if (!f->renewed.take(last.full(), track.seen.px, options.patch_px / 2)) return false;
  f->warp = startAt(f->renewed, turn);
  if (!f->renewed.align(current.full(), align_options, &f->warp)) return false;
  return observe(f->renewed.feature(f->warp), &f->now);
}

void FeatureTracker::Impl::follow(const Mat3& R_C0_C1, const ImagePyramid& target,
                                  TrackedFrame* frame) {
  predict(R_C0_C1, &frame->lost_flow);
  followFlow(last, target, start, &forward, &found, window, levels - 1, options.max_iterations);
  const bool check = options.forward_backward_px > 0.0;
  if (check) {
    // The way back is known: from where it started, the finest level is enough.
    back = start;
    followFlow(target, last, forward, &back, &found_back, window, 0, options.max_iterations);
  }
  const double limit = 0.5 * options.forward_backward_px;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < followed.size(); ++k) {
    const cv::Point2f miss = check ? back[k] - start[k] : cv::Point2f();
    if (!found[k]) {
      ++frame->lost_flow;
      continue;
    }
    if (check && (!found_back[k] || miss.dot(miss) > limit * limit)) {
      ++frame->lost_backward;
      continue;
    }
    Followed f = followed[k];
    const Track& track = tracks[f.from];
    if (!align(track, forward[k], &f)) {
      ++frame->lost_flow;
      continue;
    }
    f.now.id = track.seen.id;
    f.now.camera = number;
    f.now.age = track.seen.age + 1;
    followed[kept++] = std::move(f);
  }
  followed.resize(kept);
}

void FeatureTracker::Impl::followAsTurned(double rate_sigma, double dt, const ImagePyramid& target,
                                          Mat3* R_C0_C1, TrackedFrame* frame) {
  const double seconds = std::clamp(dt, 0.01, 1.0);
  const TrackedFrame before = *frame;
  follow(*R_C0_C1, target, frame);
  rejectOutliers(*R_C0_C1, rate_sigma * seconds, dt, frame);
  const auto lost = static_cast<double>(tracks.size() - followed.size());
  if (tracks.size() >= kTracksThatCount && lost > kNearlyAll * static_cast<double>(tracks.size())) {
    // The readings may be wrong: what turned goes on turning.
    std::vector<Followed> as_predicted = std::move(followed);
    TrackedFrame again = before;
    const Mat3 R = expSO3(turning * dt);
    follow(R, target, &again);
    rejectOutliers(R, kSteadyRateSigma * seconds, dt, &again);
    if (followed.size() > kClearlyMore * as_predicted.size()) {
      *R_C0_C1 = R;
      *frame = again;
      return;
    }
    followed = std::move(as_predicted);
  }
  if (dt > 0) turning = logSO3(*R_C0_C1) / dt;
}

void FeatureTracker::Impl::rejectOutliers(const Mat3& R_C0_C1, double sigma, double dt,
                                          TrackedFrame* frame) {
  std::vector<BearingPair> pairs(followed.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const FeatureObservation& now = followed[k].now;
    pairs[k] = {tracks[followed[k].from].seen.bearing, now.bearing, now.dpx_dbearing};
  }
  const MotionVerdict verdict = filterByMotion(pairs, R_C0_C1, sigma, options.outlier_px);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (!verdict.inlier[k]) {
      ++frame->lost_outlier;
      continue;
    }
    FeatureObservation& now = followed[k].now;
    if (dt > 0.0) now.bearing_rate = (now.bearing - pairs[k].b0) / dt;
    if (kept != k) followed[kept] = std::move(followed[k]);
    ++kept;
  }
  followed.resize(kept);
}

void FeatureTracker::Impl::thinOut(TrackedFrame* frame) {
  // Tracks run together where the camera backs away. Of two that are too close the older (with the
  // smaller id) says more.
  const double limit = std::pow(kCrowded * options.min_distance_px, 2);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < followed.size(); ++k) {
    bool crowded = false;
    for (std::size_t j = 0; j < kept && !crowded; ++j) {
      crowded = (followed[j].now.px - followed[k].now.px).squaredNorm() < limit;
    }
    if (crowded) {
      ++frame->lost_crowded;
      continue;
    }
    if (kept != k) followed[kept] = std::move(followed[k]);
    ++kept;
  }
  followed.resize(kept);
}

void FeatureTracker::Impl::keepFollowed() {
  for (std::size_t k = 0; k < followed.size(); ++k) {
    Followed& f = followed[k];
    Track& target = tracks[k];  // from >= k: nothing still needed is overwritten
    if (!f.renewed.empty()) {
      target.patch = std::move(f.renewed);
    } else if (f.from != k) {
      target.patch = std::move(tracks[f.from].patch);
    }
    target.seen = f.now;
    target.warp = f.warp;
  }
  tracks.resize(followed.size());
}

}  // namespace vir::vision
