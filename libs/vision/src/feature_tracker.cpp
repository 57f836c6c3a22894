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

namespace vir {

namespace {

// A blank image of a real sensor still has noise; seen at a quarter of the resolution its standard
// deviation is about 1 grey level.
constexpr double kBlankDeviation = 1.5;
constexpr int kBlankLevel = 2;
// Relative change of brightness or contrast between images from which the image is brought to the
// earlier one's before flow is computed: Lucas-Kanade assumes equal grey levels.
constexpr double kExposureChange = 0.04;
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

}  // namespace

struct FeatureTracker::Impl {
  Impl(const TrackerOptions& o, std::shared_ptr<const CameraModel> c)
      : options(o),
        camera(std::move(c)),
        border(std::max(4, o.window_px / 2)),
        detector({o.grid_cell_px, o.min_distance_px, o.min_corner_score, border}) {}

  std::string refuse(const cv::Mat& gray) const;
  void follow(const Mat3& R_C0_C1, const ImagePyramid& target, TrackedFrame* frame);
  void rejectOutliers(const Mat3& R_C0_C1, double dt, TrackedFrame* frame);
  bool observe(const cv::Point2f& px, FeatureObservation* f) const;
  bool insideBorder(const cv::Point2f& p) const;
  void summarise(const Mat3& R_C0_C1, TrackedFrame* frame) const;
  void detect(TrackedFrame* frame);
  const ImagePyramid& matchExposure(const Brightness& now);

  TrackerOptions options;
  std::shared_ptr<const CameraModel> camera;
  int border;
  CornerDetector detector;

  std::vector<FeatureObservation> tracks;  ///< in the last usable image, ordered by id
  std::vector<std::size_t> from;           ///< index into tracks of each feature of the new image
  std::uint64_t next_id = 0;
  TimeNs last_t = 0;
  ImagePyramid last, current, matched;
  Brightness last_brightness;
  cv::Mat matched_image;

  std::vector<cv::Point2f> start, forward, back;
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

bool FeatureTracker::Impl::insideBorder(const cv::Point2f& p) const {
  const CameraCalibration& c = camera->calibration();
  return p.x >= border && p.y >= border && p.x <= c.width - 1 - border &&
         p.y <= c.height - 1 - border;
}

bool FeatureTracker::Impl::observe(const cv::Point2f& px, FeatureObservation* f) const {
  f->px = toVec(px);
  Vec2 again;
  return camera->unproject(f->px, &f->bearing) &&
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
  current.image().convertTo(matched_image, CV_8U, limited,
                            last_brightness.mean - limited * now.mean);
  matched.build(matched_image, options.window_px, options.pyramid_levels);
  return matched;
}

void FeatureTracker::Impl::follow(const Mat3& R_C0_C1, const ImagePyramid& target,
                                  TrackedFrame* frame) {
  start.clear();
  forward.clear();
  from.clear();
  const CameraCalibration& c = camera->calibration();
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    Vec2 predicted;
    if (!camera->project(R_C0_C1.transpose() * tracks[i].bearing, &predicted)) {
      ++frame->lost_flow;
      continue;
    }
    // Translation may still bring it back inside: start at the rim.
    predicted.x() = std::clamp(predicted.x(), 0.0, c.width - 1.0);
    predicted.y() = std::clamp(predicted.y(), 0.0, c.height - 1.0);
    start.push_back(toPoint(tracks[i].px));
    forward.push_back(toPoint(predicted));
    from.push_back(i);
  }
  followFlow(last, target, start, &forward, &found, options.window_px, options.pyramid_levels,
             options.max_iterations);
  const bool check = options.forward_backward_px > 0.0;
  if (check) {
    // The way back is known: from where it started, the finest levels are enough.
    back = start;
    followFlow(target, last, forward, &back, &found_back, options.window_px,
               std::min(1, options.pyramid_levels), options.max_iterations);
  }
  const double limit = options.forward_backward_px * options.forward_backward_px;
  for (std::size_t k = 0; k < from.size(); ++k) {
    FeatureObservation f;
    if (!found[k] || !insideBorder(forward[k]) || !observe(forward[k], &f)) {
      ++frame->lost_flow;
      continue;
    }
    const cv::Point2f miss = check ? back[k] - start[k] : cv::Point2f();
    if (check && (!found_back[k] || miss.dot(miss) > limit)) {
      ++frame->lost_backward;
      continue;
    }
    const FeatureObservation& before = tracks[from[k]];
    f.id = before.id;
    f.age = before.age + 1;
    from[frame->features.size()] = from[k];
    frame->features.push_back(f);
  }
  from.resize(frame->features.size());
}

void FeatureTracker::Impl::rejectOutliers(const Mat3& R_C0_C1, double dt, TrackedFrame* frame) {
  std::vector<BearingPair> pairs(frame->features.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const FeatureObservation& f = frame->features[k];
    pairs[k] = {tracks[from[k]].bearing, f.bearing, f.dpx_dbearing};
  }
  const double sigma = kRotationRateSigma * std::clamp(dt, 0.01, 1.0);
  const MotionVerdict verdict = filterByMotion(pairs, R_C0_C1, sigma, options.outlier_px);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (!verdict.inlier[k]) {
      ++frame->lost_outlier;
      continue;
    }
    FeatureObservation& f = frame->features[k];
    if (dt > 0.0) f.bearing_rate = (f.bearing - pairs[k].b0) / dt;
    frame->features[kept] = f;
    from[kept] = from[k];
    ++kept;
  }
  frame->features.resize(kept);
  from.resize(kept);
}

void FeatureTracker::Impl::summarise(const Mat3& R_C0_C1, TrackedFrame* frame) const {
  frame->continued = static_cast<int>(frame->features.size());
  std::vector<double> flow, parallax;
  for (std::size_t k = 0; k < frame->features.size(); ++k) {
    const FeatureObservation& f = frame->features[k];
    const FeatureObservation& before = tracks[from[k]];
    flow.push_back((f.px - before.px).norm());
    parallax.push_back(
        (f.dpx_dbearing * (f.bearing - R_C0_C1.transpose() * before.bearing)).norm());
  }
  frame->median_flow_px = median(&flow);
  frame->median_parallax_px = median(&parallax);
}

void FeatureTracker::Impl::detect(TrackedFrame* frame) {
  std::vector<cv::Point2f> existing;
  for (const FeatureObservation& f : frame->features) existing.push_back(toPoint(f.px));
  const int wanted = options.max_tracks - static_cast<int>(existing.size());
  for (const cv::Point2f& p : detector.detect(current.gradient(), existing, wanted)) {
    FeatureObservation f;
    if (!insideBorder(p) || !observe(p, &f)) continue;
    f.id = next_id++;
    frame->features.push_back(f);
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
  s.current.build(gray, s.options.window_px, std::max(s.options.pyramid_levels, 0));
  const std::size_t coarse = std::min<std::size_t>(kBlankLevel, s.current.levels().size() / 2 - 1);
  if (measure(s.current.levels()[2 * coarse]).deviation < kBlankDeviation) {
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
    s.summarise(R, &frame);
  }
  frame.ms_flow = watch.lapMs();
  s.detect(&frame);
  frame.ms_detect = watch.lapMs();

  s.tracks = frame.features;
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
                              [&](const FeatureObservation& f) {
                                return std::binary_search(sorted.begin(), sorted.end(), f.id);
                              }),
               tracks.end());
}

void FeatureTracker::reset() {
  impl_->tracks.clear();
  impl_->last.clear();
  impl_->detector.reset();
}

}  // namespace vir
