#include "back_end.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "vir/core/stage_timer.h"

namespace vir::estimator {
namespace {

/// The guess across a hole in the readings is a poor one.
constexpr int kIterationsInHole = 8;
/// A state's speed is known to this while landmarks hold it, and less so on readings alone
/// [m/s, m/s^2]: a platform that is faster does not stand, whatever the image shows.
constexpr double kRestSpeed = 0.15, kSpeedDrift = 0.15;
constexpr int kLandmarksThatHold = 30;
constexpr const char* kOffsetFound = "the camera's time offset has just been found";
constexpr const char* kClockSetBack = "the clock of the IMU was set back";

}  // namespace

void BackEnd::setCamera(const CameraCalibration& calibration, const Pose& extrinsics) {
  T_B_C = extrinsics;
  const auto three = [](const std::vector<double>& v) { return Vec3(v[0], v[1], v[2]); };
  given = {calibration,
           T_B_C,
           config.camera_time_offset_s,
           config.window.readout_s,
           three(config.gyro_gain),
           three(config.gyro_axes_rad),
           three(config.acc_gain)};
  startup = std::make_unique<Startup>(config.startup, config.imu, T_B_C, focalPx());
  window = std::make_unique<window::ShortWindow>(config.window, config.imu, given);
  window->attach(&long_window);
  if (!config.window.calibrate) return;
  timing = std::make_unique<CameraTiming>(focalPx());
  expectUnknownPose();
}

Feedback BackEnd::process(Packet packet) {
  ++packets;
  takeIn(packet);
  if (packet.kind == Packet::Kind::clock_set_back) {
    clockSetBack();
  } else if (packet.kind == Packet::Kind::end) {
    // No image will come to hang them on; every range is told of.
    ranges.discard(ranges.dueUntil(std::numeric_limits<TimeNs>::max()), RangeDecision::too_late);
  } else {
    results.push_back(estimate(&packet));
  }
  Feedback out;
  out.resets = segment;
  out.time_offset_s = time_offset_s;
  if (turned) out.q_B_C = T_B_C.q;
  out.turning_C = turning_C;
  if (window) out.gyro_bias = running ? window->newest().bg : startup->gyroBias();
  if (!given.further.empty() && running) {
    const Calibration now = window->calibration();
    out.T_B_C.push_back(now.T_B_C);
    for (const CameraMount& mount : now.further) out.T_B_C.push_back(mount.T_B_C);
  }
  const WrongTracks* last = wrong_tracks.empty() ? nullptr : &wrong_tracks.back();
  if (last != nullptr && last->packet == packets) out.wrong_tracks = last->ids;
  return out;
}

void BackEnd::takeIn(const Packet& packet) {
  for (const ImuSample& s : packet.readings) imu.add(s);
  for (const Range& r : packet.ranges) ranges.offer(r);
  for (const AnchorRange& r : packet.anchor_ranges) ranges.offer(r);
  for (const DeployedAnchor& a : packet.deployed_anchors) {
    if (running) {
      ranges.putDown(a.id, inWorld(window->newest()).T_W_B * a.p_B, a.sigma_m);
    } else {
      ranges.putDownUnseen(a.id);
    }
  }
  collectRangeWarnings();
  for (const std::string& w : packet.warnings) warn(w);
}

StateEstimate BackEnd::estimate(Packet* packet) {
  StateEstimate out;
  out.t_image = packet->stamp;
  out.state.t = packet->stamp + fromSeconds(time_offset_s);
  out.ms.total = packet->ms;
  {
    StageTimer total(&out.ms.total);
    estimateInto(packet, &out);
  }
  out.segment = segment;
  return out;
}

Health BackEnd::withoutState() const {
  return running || segment > 0 ? Health::lost : Health::starting;
}

void BackEnd::estimateInto(Packet* packet, StateEstimate* out) {
  switch (packet->kind) {
    case Packet::Kind::before_imu:
      out->reason = "no IMU readings yet";
      break;
    case Packet::Kind::lost:
      out->health = withoutState();
      out->reason = kClockSetBack;
      break;
    case Packet::Kind::silent_imu:
      out->health = withoutState();
      out->reason = "no IMU readings";
      if (!running) break;
      origin = window->newest().T_W_B;
      restart("the IMU was silent");
      break;
    default:
      leaveOutWrongTracks(packet);
      estimateImage(packet, out);
  }
}

void BackEnd::estimateImage(Packet* packet, StateEstimate* out) {
  const bool covered = putOnImuClock(packet);
  const vision::TrackedFrame& frame = packet->frame;
  out->state.t = frame.t;
  elapsed.begin(frame.t);
  doubts.begin(frame.t);
  ranges.begin(frame.t);
  out->cameras = packet->cameras;
  out->tracks = tracksOf(frame);
  out->ms.pyramid = frame.ms_pyramid;
  out->ms.flow = frame.ms_flow;
  out->ms.detect = frame.ms_detect;
  pixels.clear();
  for (const vision::FeatureObservation& f : frame.features)
    pixels.emplace_back(f.px.cast<float>());
  if (packet->tracker_resets != segment) {
    // Its tracks will not go on: nothing to begin a segment with.
    out->health = Health::lost;
    out->reason = "tracked before the restart";
  } else if (!covered) {
    out->health = withoutState();
    out->reason = kOffsetFound;
  } else {
    updateRest(frame);
    checkCameraRotation(frame.t);
    if (packet->tracker_resets != segment) {
      out->health = Health::lost;
      out->reason = "started anew with the camera's rotation";
    } else {
      const double stamped_with = time_offset_s;
      if (checkTiming(frame)) out->reason = "started anew with the camera's time offset";
      packet->frame.t += fromSeconds(time_offset_s - stamped_with);
      out->state.t = frame.t;
      if (coveredByReadings(frame.t)) {
        updateOrStart(*packet, out);
      } else {
        out->health = withoutState();
        out->reason = kOffsetFound;
      }
    }
  }
  last_image = frame.t;
  if (frame.usable) last_usable = frame.t;
  dropOldReadings();
}

void BackEnd::updateOrStart(const Packet& packet, StateEstimate* out) {
  epipolar_px = packet.epipolar_px;
  if (running) return update(packet.frame, out);
  tryStart(packet.frame, out);
  if (!out->valid) wait_reasons[out->reason] += packet.since_last_s;
}

/// A tracker that is ahead may have followed tracks that have since been found to be wrong.
void BackEnd::leaveOutWrongTracks(Packet* packet) {
  while (!wrong_tracks.empty() && wrong_tracks.front().packet <= packet->feedback) {
    wrong_tracks.pop_front();
  }
  for (const WrongTracks& found : wrong_tracks) {
    const auto wrong = [&found](const vision::FeatureObservation& f) {
      return std::find(found.ids.begin(), found.ids.end(), f.id) != found.ids.end();
    };
    for (auto* of : {&packet->frame.features, &packet->frame.further}) {
      of->erase(std::remove_if(of->begin(), of->end(), wrong), of->end());
    }
  }
}

void BackEnd::clockSetBack() {
  if (running) origin = window->newest().T_W_B;
  if (window) restart(kClockSetBack);
  if (timing) timing->reset();
  imu.clear();
  last_image = last_usable = 0;
  hole = {};
  in_gap = false;
}

void BackEnd::dropOldReadings() {
  TimeNs oldest = std::min(last_usable, last_image);
  if (!running && startup->oldestTime() != 0) oldest = std::min(oldest, startup->oldestTime());
  imu.dropBefore(oldest - fromSeconds(kImuHistoryS));
}

void BackEnd::tryStart(const vision::TrackedFrame& frame, StateEstimate* out) {
  StageTimer timer(&out->ms.initialise);
  startup->setTimeOffsetSigma(timeOffsetSigma());
  startup->setRig(given, epipolar_px);
  StartupStatus status = startup->offer(frame, imu, rest, origin, window.get());
  if (status == StartupStatus::waiting && timing && timing->suggests()) {
    status = startup->offerAgain(timing->found().offset_s, imu, origin, window.get());
    if (status == StartupStatus::started_moving) tellTiming(startup->foundShift());
  }
  if (status == StartupStatus::waiting) {
    out->health = withoutState();
    out->reason = startup->reason();
    if (!startup->detail().empty()) {
      log(log_sink, LogLevel::debug, "start refused (" + out->reason + "): " + startup->detail());
    }
    return;
  }
  log(log_sink, LogLevel::info,
      std::string("started ") +
          (status == StartupStatus::started_standing ? "standing still" : "in motion") +
          (startup->detail().empty() ? "" : ": " + startup->detail()));
  shiftTimes(startup->foundShift());
  // Its images are needed again if the clocks turn out to disagree.
  if (!timing || timing->offsetKnown()) startup->reset();
  running = true;
  recent.clear();
  for (const State& s : window->states()) rememberPose(s);
  last_seen = window->newest().t;
  startLongWindow();
  window->updateCovariance();
  out->valid = true;
  out->state = inWorld(window->newest());
  out->covariance = covarianceInWorld();
  out->keyframe = true;
  window->slide(true);
  out->odometry_scale = odometryScale();
  out->landmarks = window->landmarksInNewest();
  out->health = rest.standing() ? Health::standing : Health::ok;
}

void BackEnd::update(const vision::TrackedFrame& frame, StateEstimate* out) {
  const State previous = window->newest();
  const TimeNs t = frame.t;
  bool gap = false;
  imu::Preintegration link = imu.integrate(previous.t, t, imu_noise, previous.bg, previous.ba, &gap,
                                           window->imuIntrinsics());
  noteHole(gap, previous.t, t);
  State predicted = window::predict(previous, link, config.imu.gravity_mps2, t);
  bool guessed = gap;
  if (gap) {
    guessAcrossHole(previous, frame, &predicted);
  } else {
    turning_C.reset();
    const auto seen = contradiction(previous, frame, predicted.T_W_B);
    if (wronglyStamped(frame, predicted, seen)) return leaveOut(predicted, out);
    if (contradicted(previous, frame, seen, &predicted)) {
      link = linkBySight(previous, predicted);
      guessed = true;
    }
  }
  rememberSights(frame);
  window->push(predicted, std::move(link), allSights(frame), rest.standing());
  attachRanges(previous, predicted);
  window::SolveSummary solve;
  {
    StageTimer timer(&out->ms.optimise);
    out->keyframe = window->newestIsKeyframe();
    window->triangulate();
    const bool full = out->keyframe || window->newestEndsRestLink() || (guessed && !gap);
    const int at_least = guessed ? kIterationsInHole : 0;
    solve = full || config.window.full_every_image
                ? window->optimise(std::max(at_least, config.window.iterations))
                : window->optimiseNewest(std::max(at_least, config.window.iterations_newest));
    wrong_tracks.push_back({packets, window->rejectOutliers()});
    if (solve.usable && full) updateAnchors(t);
    if (solve.usable && !full) {
      ranges.betweenKeyframes([this](std::uint64_t key) { return heldRanges(key); });
    }
  }
  out->calibration = window->calibration();
  tellLens();
  out->reprojection_rms = solve.reprojection_rms;
  out->inertial_rms = solve.inertial_rms;
  out->landmarks = window->landmarksInNewest();
  const std::string problem = failure(frame, solve, t);
  if (!problem.empty()) {
    // Carry on from where the readings say it is: better than anything that failed.
    origin = predicted.T_W_B;
    restart(problem);
    out->health = Health::lost;
    out->reason = "restarted: " + problem;
    return;
  }
  const State newest = window->newest();
  turning_B = logQuat(previous.T_W_B.q.conjugate() * newest.T_W_B.q) / toSeconds(t - previous.t);
  out->state = inWorld(newest);
  out->covariance = covarianceInWorld();
  out->odometry_scale = odometryScale();
  out->valid = true;
  const bool blind = t != last_seen;
  out->health = rest.standing() ? Health::standing : Health::ok;
  doubts.look(*out, {out->keyframe, blind, gainBeyondPrior(out->calibration)});
  if (!doubts.current().empty()) {
    out->health = Health::doubtful;
    out->reason = doubts.current();
    out->covariance *= doubts.inflation();
  }
  if (config.tell_sights && out->keyframe) tellSights(frame, out->t_image);
  {
    StageTimer timer(&out->ms.marginalise);
    window->slide(out->keyframe);
  }
  collectRetired();
}

void BackEnd::tellLens() {
  if (lens_told || !window->lensContradicted()) return;
  lens_told = true;
  warn(
      "the images contradict the given distortion of the lens: it is estimated from here on "
      "(calibration.yaml has it; `vir-slam calibrate camera` finds it from several recordings)");
}

double BackEnd::gainBeyondPrior(const Calibration& found) const {
  if (!config.window.calibrate) return 0;
  const Vec3 off = found.acc_gain - given.acc_gain;
  return off.cwiseAbs().maxCoeff() / config.window.calibration.acc_gain;
}

/// Motors that idle make the readings far noisier than in the data sheet. At rest that is seen, and
/// holds until the next rest.
void BackEnd::updateRest(const vision::TrackedFrame& frame) {
  RestDetector::Expected expected{startup->gyroBias(), config.imu.gravity_mps2, running, false,
                                  false};
  if (running) {
    expected.held = window->landmarksInNewest() >= kLandmarksThatHold;
    const State s = window->newest();
    expected.gyro_bias = s.bg;
    expected.gravity_mps2 =
        (s.T_W_B.q.conjugate() * Vec3(0, 0, config.imu.gravity_mps2) + s.ba).norm();
    const double blind_s = toSeconds(s.t - last_seen);
    const double noise = 3 * imu_noise.noise_scale * imu_noise.acc_noise_density;
    expected.moving =
        s.v.norm() > kRestSpeed + kSpeedDrift * blind_s + noise * std::sqrt(blind_s + 0.1);
  }
  rest.setExpected(expected);
  if (!rest.update(frame, imu)) return;
  imu_noise = config.imu;
  if (!rest.shaken()) return;
  const double rate = imu.rate(frame.t - fromSeconds(config.rest.min_time_s), frame.t);
  const double root = std::sqrt(3 * std::max(1.0, rate));  // the norm of three axes
  const double gyro = rest.gyroStd() / root, acc = rest.accStd() / root;
  imu_noise.gyro_noise_density =
      std::max(imu_noise.gyro_noise_density, gyro / imu_noise.noise_scale);
  imu_noise.acc_noise_density = std::max(imu_noise.acc_noise_density, acc / imu_noise.noise_scale);
}

std::string BackEnd::failure(const vision::TrackedFrame& frame, const window::SolveSummary& solve,
                             TimeNs t) {
  if (!solve.usable) return "the solver found no finite solution";
  const State s = window->newest();
  if (window->landmarksInNewest() >= 4 || rest.standing()) last_seen = t;
  if (lostInHole(frame, t)) return "the images could not bridge the missing readings";
  if (toSeconds(t - last_seen) > config.failure.max_blind_s) {
    return frame.usable ? "no landmarks for too long" : "no usable image for too long";
  }
  if (s.v.norm() > config.failure.max_speed_mps) return "implausible speed";
  if (s.ba.norm() > config.failure.max_bias_acc) return "implausible accelerometer bias";
  if (s.bg.norm() > config.failure.max_bias_gyro) return "implausible gyro bias";
  return {};
}

void BackEnd::restart(const std::string& why) {
  ++segment;
  doubts.restarted(last_image, why);
  warn("segment " + std::to_string(segment) + " starts at " + elapsed.text(last_image) + ": " +
       why);
  window->moveAllToLongWindow();
  collectRetired();
  window->clear();
  startup->reset();
  rest.reset();
  contradicted_since = 0;
  wrong_stamps_in_a_row = 0;
  stamp_jitter.reset();
  turning_C.reset();
  running = false;
}

}  // namespace vir::estimator
