#include "vir/vision/feature_tracker.h"

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "corner_detector.h"
#include "image_pyramid.h"
#include "motion_filter.h"
#include "patch.h"

namespace vir {

namespace {

// A blank image of a real sensor still has noise; seen at a quarter of the resolution its standard
// deviation is about 1 grey level.
constexpr double kBlankDeviation = 1.5;
constexpr std::size_t kBlankHalving = 1;
// Relative change of brightness or contrast between images from which the image is brought to the
// earlier one's before flow is computed: Lucas-Kanade assumes equal grey levels.
constexpr double kExposureChange = 0.04;
// Tracks nearer to each other than this share of min_distance_px are thinned out.
constexpr double kCrowded = 0.5;
// How wrong the gyro's rotation may be before its bias is known.
constexpr double kRotationRateSigma = 0.08;  // [rad/s]

class Stopwatch {
 public:
  double lapMs() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - start_).count();
    start_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

double median(std::vector<double>* values) {
  if (values->empty()) return 0.0;
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

Vec2 toVec(const cv::Point2f& p) { return {p.x, p.y}; }
cv::Point2f toPoint(const Vec2& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y())};
}

struct Brightness {
  double mean = 0.0, deviation = 0.0;
};

Brightness measure(const cv::Mat& image) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(image, mean, deviation);
  return {mean[0], deviation[0]};
}

/// A feature as last seen, with the patch it is recognised by.
struct Track {
  FeatureObservation seen;
  Patch patch;
  PatchWarp warp;  ///< patch to the last usable image
};

/// A track found in the new image; nothing of the state changes until all of them are known.
struct Followed {
  std::size_t from = 0;  ///< index of the track
  FeatureObservation now;
  PatchWarp warp;
  Patch renewed;  ///< replaces the track's patch unless empty
};

}  // namespace

struct FeatureTracker::Impl {
  Impl(const TrackerOptions& o, std::shared_ptr<const CameraModel> c)
      : options(o),
        camera(std::move(c)),
        window(std::max(5, (o.window_px / 2) | 1)),
        levels(std::max(1, o.pyramid_levels)),
        border(o.patch_px / 2 + 2),
        detector(
            {o.grid_cell_px / 2, 0.5 * o.min_distance_px, o.min_corner_score, (border + 1) / 2}) {}

  std::string refuse(const cv::Mat& gray) const;
  const ImagePyramid& matchExposure(const Brightness& now);
  void predict(const Mat3& R_C0_C1, int* lost);
  void follow(const Mat3& R_C0_C1, const ImagePyramid& target, TrackedFrame* frame);
  bool align(const Track& track, const cv::Point2f& start, Followed* f) const;
  void rejectOutliers(const Mat3& R_C0_C1, double dt, TrackedFrame* frame);
  void thinOut(TrackedFrame* frame);
  bool observe(const Vec2& px, FeatureObservation* f) const;
  bool insideBorder(const Vec2& p) const;
  void summarise(const Mat3& R_C0_C1, TrackedFrame* frame) const;
  void keepFollowed();
  void detect(TrackedFrame* frame);

  TrackerOptions options;
  std::shared_ptr<const CameraModel> camera;
  int window;  ///< of Lucas-Kanade at half resolution
  int levels;
  int border;
  CornerDetector detector;

  std::vector<Track> tracks;       ///< in the last usable image, ordered by id
  std::vector<Followed> followed;  ///< those of them found in the new image, in the same order
  std::uint64_t next_id = 0;
  TimeNs last_t = 0;
  ImagePyramid last, current, matched;
  Brightness last_brightness;
  cv::Mat matched_image;

  std::vector<cv::Point2f> start, forward, back;  ///< [px of the half resolution]
  std::vector<unsigned char> found, found_back;
};

std::string FeatureTracker::Impl::refuse(const cv::Mat& gray) const {
  const CameraCalibration& c = camera->calibration();
  if (gray.empty()) return "image is empty";
  if (gray.type() != CV_8UC1) return "image is not 8-bit with one channel";
  if (gray.cols != c.width || gray.rows != c.height) {
    return "image is " + std::to_string(gray.cols) + "x" + std::to_string(gray.rows) +
           ", calibration says " + std::to_string(c.width) + "x" + std::to_string(c.height);
  }
  return {};
}

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

const ImagePyramid& FeatureTracker::Impl::matchExposure(const Brightness& now) {
  const double gain = last_brightness.deviation / std::max(now.deviation, 1e-3);
  const double shift = std::abs(now.mean - last_brightness.mean);
  if (std::abs(gain - 1.0) < kExposureChange &&
      shift < kExposureChange * std::max(last_brightness.mean, 1.0)) {
    return current;
  }
  const double limited = std::clamp(gain, 0.1, 10.0);
  current.full().convertTo(matched_image, CV_8U, limited,
                           last_brightness.mean - limited * now.mean);
  matched.build(matched_image, window, levels);
  return matched;
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
    f.now.age = track.seen.age + 1;
    followed[kept++] = std::move(f);
  }
  followed.resize(kept);
}

void FeatureTracker::Impl::rejectOutliers(const Mat3& R_C0_C1, double dt, TrackedFrame* frame) {
  std::vector<BearingPair> pairs(followed.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const FeatureObservation& now = followed[k].now;
    pairs[k] = {tracks[followed[k].from].seen.bearing, now.bearing, now.dpx_dbearing};
  }
  const double sigma = kRotationRateSigma * std::clamp(dt, 0.01, 1.0);
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

void FeatureTracker::Impl::summarise(const Mat3& R_C0_C1, TrackedFrame* frame) const {
  frame->continued = static_cast<int>(followed.size());
  std::vector<double> flow, parallax;
  for (const Followed& f : followed) {
    const FeatureObservation& now = f.now;
    const FeatureObservation& before = tracks[f.from].seen;
    flow.push_back((now.px - before.px).norm());
    parallax.push_back(
        (now.dpx_dbearing * (now.bearing - R_C0_C1.transpose() * before.bearing)).norm());
  }
  frame->median_flow_px = median(&flow);
  frame->median_parallax_px = median(&parallax);
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

void FeatureTracker::Impl::detect(TrackedFrame* frame) {
  std::vector<cv::Point2f> existing;
  for (const Track& track : tracks) existing.push_back(toPoint(0.5 * track.seen.px));
  const int wanted = options.max_tracks - static_cast<int>(existing.size());
  for (const cv::Point2f& p : detector.detect(current.gradient(), existing, wanted)) {
    Track track;
    if (!observe(2.0 * toVec(p), &track.seen)) continue;
    if (!track.patch.take(current.full(), track.seen.px, options.patch_px / 2)) continue;
    track.warp = track.patch.origin();
    track.seen.id = next_id++;
    tracks.push_back(std::move(track));
    ++frame->detected;
  }
}

FeatureTracker::FeatureTracker(const TrackerOptions& options,
                               std::shared_ptr<const CameraModel> camera) {
  if (!camera) throw std::invalid_argument("FeatureTracker: no camera model given");
  impl_ = std::make_unique<Impl>(options, std::move(camera));
}

FeatureTracker::~FeatureTracker() = default;

TrackedFrame FeatureTracker::process(TimeNs t, const cv::Mat& gray, const Mat3& R_C0_C1) {
  Impl& s = *impl_;
  TrackedFrame frame;
  frame.t = t;
  frame.reason = s.refuse(gray);
  if (!frame.reason.empty()) {
    frame.usable = false;
    return frame;
  }
  Stopwatch watch;
  const Brightness brightness = measure(gray);
  frame.mean_intensity = brightness.mean;
  s.current.build(gray, s.window, s.levels);
  const std::size_t coarse = std::min(kBlankHalving, s.current.halvings().size() / 2 - 1);
  if (measure(s.current.halvings()[2 * coarse]).deviation < kBlankDeviation) {
    frame.usable = false;
    frame.reason = "image is blank (mean grey level " +
                   std::to_string(static_cast<int>(std::lround(brightness.mean))) + ")";
    return frame;
  }
  Mat3 R = R_C0_C1;
  if (!R.allFinite() || (R * R.transpose() - Mat3::Identity()).norm() > 1e-3) {
    frame.reason = "the rotation given is not one: tracked without prediction";
    R.setIdentity();
  }
  const bool follow = !s.last.empty() && !s.tracks.empty();
  const ImagePyramid& target = follow ? s.matchExposure(brightness) : s.current;
  frame.ms_pyramid = watch.lapMs();
  if (follow) {
    s.follow(R, target, &frame);
    s.rejectOutliers(R, toSeconds(t - s.last_t), &frame);
    s.thinOut(&frame);
    s.summarise(R, &frame);
    s.keepFollowed();
  }
  frame.ms_flow = watch.lapMs();
  s.detect(&frame);
  for (const Track& track : s.tracks) frame.features.push_back(track.seen);
  frame.ms_detect = watch.lapMs();

  s.last.swap(s.current);
  s.last_brightness = brightness;
  s.last_t = t;
  return frame;
}

void FeatureTracker::drop(const std::vector<std::uint64_t>& ids) {
  std::vector<std::uint64_t> sorted = ids;
  std::sort(sorted.begin(), sorted.end());
  auto& tracks = impl_->tracks;
  tracks.erase(std::remove_if(tracks.begin(), tracks.end(),
                              [&](const Track& track) {
                                return std::binary_search(sorted.begin(), sorted.end(),
                                                          track.seen.id);
                              }),
               tracks.end());
}

void FeatureTracker::reset() {
  impl_->tracks.clear();
  impl_->last.clear();
  impl_->detector.reset();
}

}  // namespace vir
