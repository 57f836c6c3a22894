#include <Eigen/Core>
//
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include <cmath>

#include "tracks_of.h"
#include "vir/core/order_statistics.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir {
namespace {

/// What the tracker reports of an image with which nothing is wrong.
constexpr double kIntensity = 128;

}  // namespace

bool TrackReader::observe(const camera::CameraModel& camera, vision::FeatureObservation* f) const {
  const CameraCalibration& c = camera.calibration();
  // Not in the image: NaN neither.
  if (!(f->px.x() >= 0 && f->px.y() >= 0 && f->px.x() <= c.width && f->px.y() <= c.height)) {
    return false;
  }
  Vec2 again;
  return camera.unproject(f->px, &f->bearing) &&
         camera.project(f->bearing, &again, &f->dpx_dbearing);
}

vision::TrackedFrame TrackReader::read(
    const mrpt::obs::CObservationStereoImagesFeatures& observation,
    const camera::CameraModel& camera) {
  vision::TrackedFrame frame;
  frame.t = rawlog::fromMrptTime(observation.timestamp);
  frame.mean_intensity = kIntensity;
  const double dt = toSeconds(frame.t - last_t_);
  std::map<std::uint64_t, vision::FeatureObservation> now;
  std::vector<double> flow;
  for (const mrpt::obs::TStereoImageFeatures& in : observation.theFeatures) {
    vision::FeatureObservation f;
    f.id = in.ID;
    f.px = Vec2(in.pixels.first.x, in.pixels.first.y);
    if (now.count(f.id) != 0 || !observe(camera, &f)) {
      ++unusable_;
      continue;
    }
    const auto before = last_.find(f.id);
    if (before != last_.end() && dt > 0) {
      const vision::FeatureObservation& old = before->second;
      f.age = old.age + 1;
      f.bearing_rate = (f.bearing - old.bearing) / dt;
      flow.push_back((f.px - old.px).norm());
      ++frame.continued;
    } else {
      ++frame.detected;
    }
    now[f.id] = f;
  }
  frame.lost_flow = static_cast<int>(last_.size()) - frame.continued;
  for (const auto& [id, f] : now) frame.features.push_back(f);
  if (!flow.empty()) frame.median_flow_px = medianInPlace(&flow);
  frame.usable = !frame.features.empty();
  if (!frame.usable) frame.reason = "there are no features";
  last_ = std::move(now);
  last_t_ = frame.t;
  return frame;
}

}  // namespace vir
