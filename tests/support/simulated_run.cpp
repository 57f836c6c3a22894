#include "simulated_run.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "vir/evaluation/nees.h"

namespace vir::tool {
namespace {

/// Lines of the estimator, with the seed before them, to the file that is asked for.
LogSink sinkOf(const RunSettings& s, int seed) {
  if (!s.log) return {};
  return [file = s.log, seed](LogLevel, const std::string& line) {
    std::fprintf(file, "seed %d: %s\n", seed, line.c_str());
  };
}

/// Feeds what the sensors saw in the order of time, images after the readings that they need.
class Feeder {
 public:
  Feeder(const std::shared_ptr<const simulation::Motion>& motion, const RunSettings& s, int seed)
      : settings_(s),
        imu_(simulation::simulateImu(*motion, s.imu)),
        tracks_(s.tracks, motion, camera::makeCamera(s.camera), s.T_B_C),
        estimator_(s.estimator, sinkOf(s, seed)) {
    if (s.given_camera) given_camera_ = camera::makeCamera(*s.given_camera);
    estimator_.setCamera(s.given_camera.value_or(s.camera), s.given_T_B_C.value_or(s.T_B_C));
    if (s.use_ranges) ranges_ = simulation::simulateRanges(*motion, s.ranges);
  }

  void run() {
    std::size_t next = 0, next_range = 0;
    const std::vector<TimeNs>& times = tracks_.times();
    for (std::size_t k = 0; k < times.size(); ++k) {
      const TimeNs t = times[k];
      for (; next < imu_.samples.size() && imu_.samples[next].t <= t; ++next) {
        const ImuSample& s = imu_.samples[next];
        if (silent(s.t)) continue;
        estimator_.addImu(within(settings_.false_imu_s, s.t) ? settings_.false_imu(s) : s);
      }
      for (; next_range < ranges_.size() && ranges_[next_range].t <= t; ++next_range) {
        addRange(ranges_[next_range]);
      }
      vision::TrackedFrame seen = shown(k);
      seen.t += fromSeconds(settings_.images_late_s + 1e-6 * settings_.camera_clock_ppm *
                                                          toSeconds(t - imu_.samples.front().t));
      estimator_.addTracks(seen);
      collect();
    }
    for (; next < imu_.samples.size(); ++next) estimator_.addImu(imu_.samples[next]);
    estimator_.finish();
    collect();
  }

  const std::vector<StateEstimate>& frames() const { return frames_; }
  const std::vector<RangeRecord>& decisions() const { return decisions_; }
  const estimator::VisualInertialEstimator& estimator() const { return estimator_; }
  long ranges() const { return static_cast<long>(ranges_.size()); }

 private:
  bool within(const std::pair<double, double>& stretch_s, TimeNs t) const {
    const double s = toSeconds(t - imu_.samples.front().t);
    return s > stretch_s.first && s < stretch_s.second;
  }
  /// What comes as the k-th image.
  vision::TrackedFrame shown(std::size_t k) {
    const std::vector<TimeNs>& times = tracks_.times();
    vision::TrackedFrame seen = std::exchange(swapped_, {});
    if (seen.features.empty()) seen = seenAt(times[k]);
    if (k % 20 == 0 && within(settings_.swapped_images_s, times[k])) {
      swapped_ = std::exchange(seen, seenAt(times[k + 1]));
    }
    seen.t = times[k];
    return seen;
  }
  bool silent(TimeNs t) const { return within(settings_.silent_imu_s, t); }
  vision::TrackedFrame seenAt(TimeNs t) {
    if (!within(settings_.frozen_camera_s, t)) return last_seen_ = asGiven(tracks_.at(t));
    vision::TrackedFrame again = last_seen_;
    again.t = t;
    for (vision::FeatureObservation& f : again.features) f.bearing_rate.setZero();
    return again;
  }
  /// The bearings that the given camera makes of the pixels.
  vision::TrackedFrame asGiven(vision::TrackedFrame frame) const {
    if (!given_camera_) return frame;
    for (vision::FeatureObservation& f : frame.features) {
      Vec2 again;
      const bool seen = given_camera_->unproject(f.px, &f.bearing) &&
                        given_camera_->project(f.bearing, &again, &f.dpx_dbearing);
      if (!seen) throw std::logic_error("the given camera cannot see what the true one does");
    }
    return frame;
  }
  void addRange(const simulation::SimulatedRange& r) {
    Range m;
    m.t = r.t;
    m.anchor = static_cast<std::uint64_t>(r.anchor);
    m.range_m = r.range_m;
    m.sigma_m = settings_.ranges.sigma_m;
    m.p_B_U = Vec3(settings_.ranges.lever_arm_m.data());
    estimator_.addRange(m);
  }
  void collect() {
    for (StateEstimate& f : estimator_.take()) frames_.push_back(std::move(f));
    for (RangeRecord& d : estimator_.takeRanges()) decisions_.push_back(std::move(d));
  }

  const RunSettings& settings_;
  simulation::SimulatedImu imu_;
  simulation::TrackSimulator tracks_;
  std::shared_ptr<const camera::CameraModel> given_camera_;
  vision::TrackedFrame last_seen_, swapped_;
  estimator::VisualInertialEstimator estimator_;
  std::vector<simulation::SimulatedRange> ranges_;
  std::vector<StateEstimate> frames_;
  std::vector<RangeRecord> decisions_;
};

PoseError errorOf(const StateEstimate& f, const Pose& truth, const Pose& T_R_E) {
  const Pose e = T_R_E * f.state.T_W_B;
  PoseError out;
  out.t = f.state.t;
  out.position = e.p - truth.p;
  out.rotation_rad = logQuat(truth.q.conjugate() * e.q).norm();
  out.yaw_rad = nearestYaw(e.R() * truth.R().transpose());
  out.tracks = f.tracks;
  out.landmarks = f.landmarks;
  out.health = healthText(f);
  const Mat3 P = T_R_E.R() * f.covariance.topLeftCorner<3, 3>() * T_R_E.R().transpose();
  out.sigma = P.diagonal().cwiseMax(0).cwiseSqrt();
  double value = 0;
  if (evaluation::nees(out.position, P, &value)) out.nees = value;
  return out;
}

AnchorError errorOf(const Anchor& a, const simulation::RangeSimulationOptions& ranges, double end_s,
                    const Pose& T_R_E, const Pose& aligned) {
  AnchorError out;
  out.id = static_cast<int>(a.id);
  out.state = name(a.state);
  std::size_t index = a.id;
  for (std::size_t k = 0; k < ranges.anchor_id.size(); ++k) {
    if (ranges.anchor_id[k] == static_cast<double>(a.id)) index = k;
  }
  if (!a.has_position || 3 * index >= ranges.anchor_m.size()) return out;
  out.found = true;
  const Vec3 truth = simulation::anchorAt(ranges, index, end_s);
  const Vec3 error = T_R_E * a.p_W - truth, after = aligned * a.p_W - truth;
  out.error_first_m = error.norm();
  out.error_m = after.norm();
  out.horizontal_m = after.head<2>().norm();
  double value = 0;
  if (evaluation::nees(error, T_R_E.R() * a.covariance * T_R_E.R().transpose(), &value))
    out.nees = value;
  return out;
}

/// Of the keyframes as they were last seen, position and yaw aligned; -1 if there are too few.
double smoothedError(const simulation::Motion& motion, const std::vector<State>& keyframes) {
  Trajectory estimate, truth;
  for (const State& k : keyframes) {
    if (!estimate.empty() && k.t <= estimate.back().t) continue;
    estimate.push_back({k.t, k.T_W_B});
    truth.push_back({k.t, motion.poseAt(k.t)});
  }
  return estimate.size() < 10 ? -1 : evaluation::evaluate(truth, estimate, {}).ate_position_m.rmse;
}

}  // namespace

RunResult simulateRun(const std::shared_ptr<const simulation::Motion>& motion, RunSettings s,
                      int seed) {
  s.imu.seed = s.tracks.seed = s.ranges.seed = seed;
  Feeder feeder(motion, s, seed);
  feeder.run();
  RunResult out;
  out.seed = seed;
  out.calibration = feeder.estimator().calibration();
  out.doubts = feeder.estimator().doubts();
  out.warnings = feeder.estimator().warnings();
  out.counters = feeder.estimator().counters();
  out.resets = feeder.estimator().resets();
  out.ranges = feeder.ranges();
  double ms = 0, tracks = 0;
  for (const StateEstimate& f : feeder.frames()) {
    ms += f.ms.total;
    tracks += f.tracks;
    if (!f.valid) continue;
    out.estimate.push_back({f.state.t, f.state.T_W_B});
    out.truth.push_back({f.state.t, motion->poseAt(f.state.t)});
  }
  const double n = std::max<double>(1, static_cast<double>(feeder.frames().size()));
  out.ms_per_frame = ms / n;
  out.mean_tracks = tracks / n;
  if (out.estimate.size() < 10) {
    out.note = "did not start: " + feeder.estimator().longestWaitReason();
    return out;
  }
  out.valid = true;
  out.init_s = toSeconds(out.estimate.front().t - feeder.frames().front().state.t);
  out.evaluation = evaluation::evaluate(out.truth, out.estimate, {});
  const State first = feeder.estimator().keyframes().front();
  const Pose T_R_E = evaluation::gaugeAt(motion->poseAt(first.t), first.T_W_B);
  double nees = 0;
  long count = 0;
  for (const StateEstimate& f : feeder.frames()) {
    if (!f.valid) continue;
    const PoseError e = errorOf(f, motion->poseAt(f.state.t), T_R_E);
    if (!out.errors.empty()) {
      const Vec3 change = e.position - out.errors.back().position;
      out.largest_jump_m = std::max(out.largest_jump_m, change.norm());
    }
    out.errors.push_back(e);
    if (out.errors.back().nees < 0) continue;
    nees += out.errors.back().nees;
    ++count;
  }
  for (const Anchor& a : feeder.estimator().anchors()) {
    out.anchors.push_back(
        errorOf(a, s.ranges, motion->duration(), T_R_E, out.evaluation.transform.T_R_E));
  }
  out.smoothed_ate_m = smoothedError(*motion, feeder.estimator().keyframes());
  for (const RangeRecord& d : feeder.decisions()) ++out.decisions[name(d.decision)];
  if (count > 0) out.mean_nees = nees / static_cast<double>(count);
  out.end_error_m = out.errors.back().position.norm();
  return out;
}

}  // namespace vir::tool
