#include "vir/vision/feature_tracker.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tracker_impl.h"
#include "vir/core/order_statistics.h"
#include "vir/core/stage_timer.h"

namespace vir::vision {

namespace {

// A blank image of a real sensor still has noise; seen at a quarter of the resolution its standard
// deviation is about 1 grey level.
constexpr double kBlankDeviation = 1.5;
constexpr std::size_t kBlankHalving = 1;
// An image of less than this share of the last one's contrast in which hardly a track is found
// again is left out, but not for longer than this: then the scene is taken to be so.
constexpr double kFaintShare = 0.2;
constexpr TimeNs kFaintTimeNs = 1500000000;
// Relative change of brightness or contrast between images from which the image is brought to the
// earlier one's before flow is computed: Lucas-Kanade assumes equal grey levels.
constexpr double kExposureChange = 0.04;

Brightness measure(const cv::Mat& image) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(image, mean, deviation);
  return {mean[0], deviation[0]};
}

}  // namespace

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
  frame->median_flow_px = medianInPlace(&flow);
  frame->median_parallax_px = medianInPlace(&parallax);
}

bool FeatureTracker::Impl::tooDark(const Brightness& now, TimeNs t) const {
  return now.deviation < kFaintShare * last_brightness.deviation && tracks.size() >= 10 &&
         followed.size() < tracks.size() / 5 && t - last_t < kFaintTimeNs;
}

void FeatureTracker::Impl::detect(TrackedFrame* frame) {
  std::vector<cv::Point2f> existing;
  for (const Track& track : tracks) existing.push_back(toPoint(0.5 * track.seen.px));
  const int wanted = budget - static_cast<int>(existing.size());
  for (const cv::Point2f& p : detector.detect(current.gradient(), existing, wanted)) {
    Track track;
    if (!observe(2.0 * toVec(p), &track.seen)) continue;
    if (!track.patch.take(current.full(), track.seen.px, options.patch_px / 2)) continue;
    track.warp = track.patch.origin();
    track.seen.id = next_id++;
    track.seen.camera = number;
    tracks.push_back(std::move(track));
    ++frame->detected;
  }
}

FeatureTracker::FeatureTracker(const TrackerOptions& options,
                               std::shared_ptr<const camera::CameraModel> camera, int number) {
  if (!camera) throw std::invalid_argument("FeatureTracker: no camera model given");
  options.validate();
  impl_ = std::make_unique<Impl>(options, std::move(camera));
  impl_->number = number;
  impl_->next_id = static_cast<std::uint64_t>(number) << kIdBits;
}

FeatureTracker::~FeatureTracker() = default;

TrackedFrame FeatureTracker::process(TimeNs t, const cv::Mat& gray, const Mat3& R_C0_C1) {
  return impl_->process(t, gray, R_C0_C1, kRotationRateSigma);
}

TrackedFrame FeatureTracker::processTurning(TimeNs t, const cv::Mat& gray, const Vec3& rate) {
  const double dt = impl_->last_t == 0 ? 0 : toSeconds(t - impl_->last_t);
  return impl_->process(t, gray, expSO3(rate * dt), kSteadyRateSigma);
}

TrackedFrame FeatureTracker::Impl::process(TimeNs t, const cv::Mat& gray, const Mat3& R_C0_C1,
                                           double rate_sigma) {
  TrackedFrame frame = followInto(t, gray, R_C0_C1, rate_sigma);
  if (!frame.usable) return frame;
  detect(&frame);
  conclude(&frame);
  return frame;
}

TrackedFrame FeatureTracker::Impl::followInto(TimeNs t, const cv::Mat& gray, const Mat3& R_C0_C1,
                                              double rate_sigma) {
  TrackedFrame frame;
  frame.t = t;
  frame.reason = refuse(gray);
  if (!frame.reason.empty()) {
    frame.usable = false;
    return frame;
  }
  watch = StageLaps();
  const Brightness brightness = measure(gray);
  frame.mean_intensity = brightness.mean;
  current.build(gray, window, levels);
  const std::size_t coarse = std::min(kBlankHalving, current.halvings().size() / 2 - 1);
  if (measure(current.halvings()[2 * coarse]).deviation < kBlankDeviation) {
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
  const bool follow = !last.empty() && !tracks.empty();
  const ImagePyramid& target = follow ? matchExposure(brightness) : current;
  frame.ms_pyramid = watch.lapMs();
  if (follow) {
    followAsTurned(rate_sigma, toSeconds(t - last_t), target, &R, &frame);
    if (tooDark(brightness, t)) {
      TrackedFrame dark;
      dark.t = t;
      dark.mean_intensity = brightness.mean;
      dark.usable = false;
      dark.reason = "image is too dark or too faint to find the tracks again (contrast " +
                    std::to_string(static_cast<int>(std::lround(brightness.deviation))) +
                    " after " +
                    std::to_string(static_cast<int>(std::lround(last_brightness.deviation))) + ")";
      return dark;
    }
    thinOut(&frame);
    summarise(R, &frame);
    keepFollowed();
  }
  frame.ms_flow = watch.lapMs();
  current_brightness = brightness;
  return frame;
}

void FeatureTracker::Impl::conclude(TrackedFrame* frame) {
  for (const Track& track : tracks) frame->features.push_back(track.seen);
  frame->ms_detect = watch.lapMs();
  last.swap(current);
  last_brightness = current_brightness;
  last_t = frame->t;
}

bool FeatureTracker::Impl::adopt(std::uint64_t id, const Vec2& px) {
  const auto at = std::lower_bound(tracks.begin(), tracks.end(), id,
                                   [](const Track& t, std::uint64_t x) { return t.seen.id < x; });
  if (at != tracks.end() && at->seen.id == id) return false;
  Track track;
  if (!observe(px, &track.seen)) return false;
  if (!track.patch.take(current.full(), px, options.patch_px / 2)) return false;
  track.warp = track.patch.origin();
  track.seen.id = id;
  track.seen.camera = number;
  tracks.insert(at, std::move(track));
  return true;
}

void FeatureTracker::stopFollowing(const std::vector<std::uint64_t>& ids) {
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

}  // namespace vir::vision
