#include "simulated_run.h"

#include <algorithm>
#include <cmath>

#include "vir/evaluation/nees.h"

namespace vir::tool {
namespace {

/// Yaw that is nearest to a rotation; well defined whatever axis of the body points up.
double nearestYaw(const Mat3& R) { return std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1)); }

/// T_R_E, position and yaw only, that lays an estimated pose onto the true one.
Pose gauge(const Pose& truth, const Pose& estimate) {
  const Mat3 R = rotZ(nearestYaw(truth.R() * estimate.R().transpose()));
  return {Quat(R), truth.p - R * estimate.p};
}

/// Feeds what the sensors saw in the order of time, images after the readings that they need.
class Feeder {
 public:
  Feeder(const std::shared_ptr<const Motion>& motion, const RunSettings& s)
      : antenna_(s.ranges.lever_arm_m.data()),
        range_sigma_m_(s.ranges.sigma_m),
        imu_(simulateImu(*motion, s.imu)),
        tracks_(s.tracks, motion, makeCamera(s.camera), s.T_B_C),
        estimator_(s.estimator) {
    estimator_.setCamera(s.camera, s.T_B_C);
    if (s.use_ranges) ranges_ = simulateRanges(*motion, s.ranges);
  }

  void run() {
    std::size_t next = 0, next_range = 0;
    for (const TimeNs t : tracks_.times()) {
      for (; next < imu_.samples.size() && imu_.samples[next].t <= t; ++next) {
        estimator_.addImu(imu_.samples[next]);
      }
      for (; next_range < ranges_.size() && ranges_[next_range].t <= t; ++next_range) {
        addRange(ranges_[next_range]);
      }
      estimator_.addTracks(tracks_.at(t));
      collect();
    }
    for (; next < imu_.samples.size(); ++next) estimator_.addImu(imu_.samples[next]);
    estimator_.finish();
    collect();
  }

  const std::vector<FrameEstimate>& frames() const { return frames_; }
  const VisualInertialEstimator& estimator() const { return estimator_; }
  long ranges() const { return static_cast<long>(ranges_.size()); }

 private:
  void addRange(const SimulatedRange& r) {
    RangeMeasurement m;
    m.t = r.t;
    m.anchor = static_cast<std::uint64_t>(r.anchor);
    m.range_m = r.range_m;
    m.sigma_m = range_sigma_m_;
    m.p_B_U = antenna_;
    estimator_.addRange(m);
  }
  void collect() {
    for (FrameEstimate& f : estimator_.take()) frames_.push_back(std::move(f));
  }

  Vec3 antenna_;
  double range_sigma_m_;
  SimulatedImu imu_;
  TrackSimulator tracks_;
  VisualInertialEstimator estimator_;
  std::vector<SimulatedRange> ranges_;
  std::vector<FrameEstimate> frames_;
};

PoseError errorOf(const FrameEstimate& f, const Pose& truth, const Pose& T_R_E) {
  const Pose e = T_R_E * f.state.T_W_B;
  PoseError out;
  out.t = f.t;
  out.position = e.p - truth.p;
  out.rotation_rad = logQuat(truth.q.conjugate() * e.q).norm();
  out.yaw_rad = nearestYaw(e.R() * truth.R().transpose());
  out.tracks = f.tracks;
  out.landmarks = f.landmarks;
  out.health = f.health;
  const Mat3 P = T_R_E.R() * f.covariance.topLeftCorner<3, 3>() * T_R_E.R().transpose();
  out.sigma = P.diagonal().cwiseMax(0).cwiseSqrt();
  double value = 0;
  if (nees(out.position, P, &value)) out.nees = value;
  return out;
}

}  // namespace

RunResult simulateRun(const std::shared_ptr<const Motion>& motion, RunSettings s, int seed) {
  s.imu.seed = s.tracks.seed = s.ranges.seed = seed;
  Feeder feeder(motion, s);
  feeder.run();
  RunResult out;
  out.seed = seed;
  out.resets = feeder.estimator().resets();
  out.ranges = feeder.ranges();
  double ms = 0, tracks = 0;
  for (const FrameEstimate& f : feeder.frames()) {
    ms += f.ms_total;
    tracks += f.tracks;
    if (!f.valid) continue;
    out.estimate.push_back({f.t, f.state.T_W_B});
    out.truth.push_back({f.t, motion->poseAt(f.t)});
  }
  const double n = std::max<double>(1, static_cast<double>(feeder.frames().size()));
  out.ms_per_frame = ms / n;
  out.mean_tracks = tracks / n;
  if (out.estimate.size() < 10) {
    out.note = "did not start: " + feeder.estimator().longestWaitReason();
    return out;
  }
  out.valid = true;
  out.init_s = toSeconds(out.estimate.front().t - feeder.frames().front().t);
  out.evaluation = evaluate(out.truth, out.estimate, {});
  const NavState first = feeder.estimator().keyframes().front();
  const Pose T_R_E = gauge(motion->poseAt(first.t), first.T_W_B);
  double nees = 0;
  long count = 0;
  for (const FrameEstimate& f : feeder.frames()) {
    if (!f.valid) continue;
    out.errors.push_back(errorOf(f, motion->poseAt(f.t), T_R_E));
    if (out.errors.back().nees < 0) continue;
    nees += out.errors.back().nees;
    ++count;
  }
  const Pose aligned = out.evaluation.transform.T_R_E;
  for (const AnchorReport& a : feeder.estimator().anchors()) {
    AnchorError e;
    e.id = static_cast<int>(a.id);
    e.state = a.state;
    if (a.has_position) {
      const Vec3 truth = anchorAt(s.ranges, a.id, toSeconds(motion->end() - motion->begin()));
      const Vec3 error = T_R_E * a.p_W - truth;
      e.error_first_m = error.norm();
      const Vec3 after = aligned * a.p_W - truth;
      e.error_m = after.norm();
      e.horizontal_m = after.head<2>().norm();
      const Mat3 P = T_R_E.R() * a.covariance * T_R_E.R().transpose();
      if (P.trace() > 0) e.nees = error.dot(P.ldlt().solve(error));
    }
    out.anchors.push_back(e);
  }
  if (count > 0) out.mean_nees = nees / static_cast<double>(count);
  out.end_error_m = out.errors.back().position.norm();
  return out;
}

}  // namespace vir::tool
