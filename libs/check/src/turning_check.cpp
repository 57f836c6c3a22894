#include "vir/check/turning_check.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "camera_mounting.h"
#include "lens_fit.h"
#include "stamp_noise.h"
#include "text.h"
#include "turn_axes.h"
#include "turn_clock.h"
#include "vir/core/angles.h"
#include "vir/core/order_statistics.h"
#include "vir/imu/imu_buffer.h"

namespace vir::check {
namespace {

constexpr std::size_t kFewest = 30;  // pairs that turn, to say anything
constexpr double kTurning = 0.08;    // [rad/s] by images, to count as turning
constexpr std::size_t kMostPairs = 20000, kMostMatched = 2000;
constexpr double kSmallBias = 0.02;  // [rad/s] that is not worth a word
constexpr double kLargeBias = 0.15;  // [rad/s] beyond what a sensor that works has
constexpr double kLeastRatio = 0.85, kMostRatio = 1.18;  // of rates, the unit being right
constexpr double kOtherFocal = 0.06;  // share, that an estimate does not find by itself
constexpr double kOtherLens = 0.1;    // of rays at 45 deg from the axis, as a share
constexpr double kWrongAngle = 15;    // [deg] between rotation found and given
constexpr std::size_t kMostReadings = 400'000;
constexpr double kReachS = 0.2;  // offsets of the clocks looked for, to both sides
/// Turning about other axes, below which one rotation is as good as another.
constexpr double kFewAxes = 0.15;
constexpr double kWrongShare = 0.8;  // left unexplained by what is given, which then is wrong
constexpr double kFits = 0.45;       // rest of the rate that a rotation leaves, as a share

double angleDeg(const Mat3& R) { return kDegPerRad * logSO3(R).norm(); }

std::vector<TurnPair> thatTurn(const std::vector<TurnPair>& pairs) {
  std::vector<TurnPair> out;
  for (const TurnPair& p : pairs) {
    if (p.image_C.norm() > kTurning) out.push_back(p);
  }
  return out;
}

}  // namespace

void TurningCheck::add(const ImuSample& sample) {
  if (!sample.gyro.allFinite() || (!readings_.empty() && sample.t <= readings_.back().t)) return;
  readings_.push_back(sample);
  keepBeside(sample);
  pairUp();
}

void TurningCheck::keepBeside(const ImuSample& sample) {
  const bool more = turns_.empty() || toSeconds(sample.t - turns_.back().t1) < 2 * kReachS;
  if (!more || beside_.size() >= kMostReadings) return;
  beside_.push_back(sample);
  if (!turns_.empty() || beside_.size() < 2000) return;
  // No image yet: only the last second is of use.
  const auto old = std::find_if(beside_.begin(), beside_.end(),
                                [&](const ImuSample& s) { return toSeconds(sample.t - s.t) < 1; });
  beside_.erase(beside_.begin(), old);
}

void TurningCheck::add(const ImageTurn& turn) {
  waiting_.push_back(turn);
  waiting_.back().matches.clear();
  if (turns_.size() < kMostPairs) turns_.push_back(turn);
  if (turns_.size() > kMostMatched) turns_.back().matches.clear();
  pairUp();
}

void TurningCheck::pairUp() {
  while (!waiting_.empty() && !readings_.empty() && readings_.back().t > waiting_.front().t1) {
    const ImageTurn turn = waiting_.front();
    waiting_.pop_front();
    while (readings_.size() > 1 && readings_[1].t <= turn.t0) readings_.pop_front();
    TurnPair pair;
    pair.t0 = turn.t0;
    pair.t1 = turn.t1;
    int n = 0;
    for (const ImuSample& s : readings_) {
      if (s.t < turn.t0 || s.t > turn.t1) continue;
      pair.gyro_B += s.gyro;
      ++n;
    }
    const double dt = toSeconds(turn.t1 - turn.t0);
    if (n == 0 || dt <= 0 || pairs_.size() >= kMostPairs) continue;
    pair.gyro_B /= n;
    pair.image_C = turn.rotation_C / dt;
    pairs_.push_back(pair);
  }
  // Readings before the first image are of no use.
  while (waiting_.empty() && readings_.size() > 4000) readings_.pop_front();
}

namespace {

/// Reads as a gyro in deg/s.
bool inDegrees(double ratio) { return ratio > 20 && ratio < 160; }
bool inMillidegrees(double ratio) { return ratio > 30000 && ratio < 110000; }

std::string ratesOf(double ratio) {
  return "where the images turn by 1 rad/s the gyro says " + num(ratio) + ", a constant aside";
}

/// What the share of turning that gyro and images see says of the gyro's unit.
std::vector<Finding> unitFindings(double ratio, const std::string& imu_label) {
  const std::string rates = ratesOf(ratio);
  if (inDegrees(ratio)) {
    return {{Severity::unusable, "gyro_in_deg", imu_label, "the gyro is in deg/s, not in rad/s",
             rates, kDegreesRemedy}};
  }
  if (inMillidegrees(ratio)) {
    return {{Severity::unusable, "gyro_in_mdeg", imu_label, "the gyro is in mdeg/s, not in rad/s",
             rates, kMillidegreesRemedy}};
  }
  if (ratio >= 0.5 && ratio <= 2) return {};
  return {{Severity::unusable, "gyro_scale", imu_label,
           "gyro and images disagree on how fast it turns", rates,
           "check the gyro's unit and columns, and the camera's focal length"}};
}

Finding biasFinding(const Vec3& bias, const std::string& imu_label) {
  const bool large = bias.norm() > kLargeBias;
  const std::string value =
      "(" + num(bias.x(), 2) + ", " + num(bias.y(), 2) + ", " + num(bias.z(), 2) + ") rad/s";
  return {large ? Severity::doubtful : Severity::note,
          "gyro_bias",
          imu_label,
          large ? "the gyro has a large bias: " + value : "the gyro's bias as found: " + value,
          "so much it says beside the turning of the images",
          large ? "subtract it, or let the sensor find it anew while it rests after "
                  "switching on"
                : ""};
}

/// What images and gyro say of the camera: which of focal length and lens it is where that is told.
std::optional<Finding> cameraFinding(const LensFit& lens, double ratio,
                                     const std::string& camera_label) {
  const std::string evidence = "of the misfit of gyro and images other rays leave " +
                               num(100 * lens.best / lens.as_given, 2) + " % (" +
                               std::to_string(lens.turns) + " turns)";
  if (lens.told && std::abs(lens.scale - 1) > kOtherFocal) {
    return Finding{Severity::doubtful,
                   "camera_focal",
                   camera_label,
                   "its focal length does not fit: with " + num(lens.scale, 3) +
                       " times of what is given the images turn as the gyro says",
                   evidence,
                   "check the focal length, and that it is for images of this size; else the "
                   "gyro's scale"};
  }
  if (lens.told && std::abs(lens.bend) > kOtherLens) {
    return Finding{Severity::doubtful,
                   "camera_lens",
                   camera_label,
                   "its lens model or the coefficients do not fit",
                   evidence + ": near the middle they are as given, at 30 deg from it " +
                       num(100 * std::abs(lens.bend) / 3, 2) + " % " +
                       (lens.bend > 0 ? "further out" : "further in"),
                   "check the model (radtan, equidistant, ...) and that the coefficients are "
                   "given, and are of this lens"};
  }
  if (ratio > kLeastRatio && ratio < kMostRatio) return std::nullopt;
  // A gyro is right to some per cent, as long as its unit is.
  return Finding{Severity::doubtful,
                 "camera_scale",
                 camera_label,
                 "its focal length or its lens model does not fit: the images turn " +
                     num(1 / ratio) + " times as fast as the gyro says",
                 ratesOf(ratio),
                 "check intrinsics, lens model (radtan, equidistant, ...) and coefficients, and "
                 "that they are for images of this size; else the gyro's scale"};
}

std::string percent(double share) { return num(100 * share, 2) + " %"; }

/// A mirror explains what no rotation does; less clearly so where it is one of axes that are
/// negated or exchanged, and what is given is wrong anyway.
bool mirrorExplains(const AxesFit& fit, double share_given, bool named) {
  if (fit.mirror_rest > kFits || fit.second_axis < kFewAxes) return false;
  return fit.mirror_rest < 0.6 * fit.rotation_rest ||
         (named && share_given > kWrongShare && fit.mirror_rest < 0.8 * fit.rotation_rest);
}

/// Both see turning of which no rotation, or only a mirror, makes the other. `share_given`: what
/// the rotation given leaves unexplained.
std::vector<Finding> axesFindings(const AxesFit& fit, double share_given, const Mat3& R_B_C,
                                  const std::string& camera_label, const std::string& imu_label) {
  if (std::min(fit.rotation_rest, fit.mirror_rest) > 0.7) {
    return {
        {Severity::doubtful, "turns_apart", camera_label, "does not turn together with the gyro",
         "no rotation between the two explains " + percent(fit.rotation_rest) + " of the turning",
         "check that the stamps of both are from one clock"}};
  }
  const std::string axes = axesNamed(R_B_C * fit.mirror);
  if (!mirrorExplains(fit, share_given, !axes.empty())) return {};
  const bool negated = axes == "x is -x, y is -y, z is -z";
  return {{Severity::unusable, "gyro_mirrored", imu_label,
           std::string(negated ? "the gyro is negated" : "the gyro's axes are mirrored") +
               (axes.empty() || negated ? "" : ": its " + axes),
           "a mirror leaves " + percent(fit.mirror_rest) + " of the turning, a rotation " +
               percent(fit.rotation_rest),
           negated ? "negate all three axes of the gyro"
                   : "one axis has the wrong sign, or two are exchanged; a driver whose axes are "
                     "left-handed has the accelerometer's wrong as well: put the same right in "
                     "both, and check again"}};
}

/// What is given is wrong, but what is right the turning does not tell.
Finding turnsOtherwise(const AxesFit& fit, double share_given, const std::string& camera_label) {
  return {Severity::doubtful,
          "turns_otherwise",
          camera_label,
          "turns about other axes than the gyro says with the pose given",
          "what is given leaves " + percent(share_given) + " of the turning, the best rotation " +
              percent(fit.rotation_rest),
          "check T_BS (which way round?) and the signs and order of the gyro's columns; a piece "
          "with more turning about all axes tells which"};
}

/// The rotation given or the one found, as the turning has it; with a finding where they differ.
/// `share_given`: of the turning that the rotation given leaves unexplained.
void judgeRotation(const AxesFit& fit, double share_given, const Mat3& given,
                   const std::string& camera_label,
                   const std::function<ForceSign(const Mat3&)>& force_with, TurningVerdict* out) {
  const Mat3 found = fit.rotation.transpose();
  const double off = angleDeg(given * fit.rotation);
  const bool told = fit.second_axis >= kFewAxes;
  const bool better = fit.rotation_rest < 0.6 * share_given;
  if (off < kWrongAngle && told) {
    out->R_B_C = given;
    return;
  }
  if (!told || !better || fit.rotation_rest >= kFits) {
    if (better && share_given > kWrongShare && !given.isIdentity(1e-9)) {
      out->findings.push_back(turnsOtherwise(fit, share_given, camera_label));
    }
    return;
  }
  out->R_B_C = found;
  if (given.isIdentity(1e-9)) {
    out->findings.push_back(
        {Severity::note, "camera_pose_missing", camera_label, "its pose on the IMU is not given",
         "the rotation found explains all but " + percent(fit.rotation_rest) + " of the turning",
         "a run finds it on the way; give it (T_BS, Kalibr's T_cam_imu), or find it once: "
         "vir-slam calibrate camera"});
    return;
  }
  const MountingFault fault =
      mountingFault(given, found, force_with(found).sign(), camera_label,
                    "by " + num(off) + " deg: what is given leaves " + percent(share_given) +
                        " of the turning, what was found " + percent(fit.rotation_rest));
  // What a mirror explains needs no second fault.
  if (fault.images_mirrored) out->R_B_C.reset();
  out->findings.push_back(fault.finding);
}

Finding hardlyTurns(std::size_t turning, std::size_t all, const std::string& camera_label) {
  return {Severity::note,
          "hardly_turns",
          camera_label,
          "turns too little to hold the gyro against it",
          std::to_string(turning) + " of " + std::to_string(all) + " images turn faster than " +
              num(kTurning) + " rad/s",
          ""};
}

/// Median rate of a stream [Hz].
template <typename Items, typename Time>
double rateOf(const Items& items, Time time) {
  std::vector<TimeNs> periods;
  for (std::size_t i = 1; i < items.size(); ++i)
    periods.push_back(time(items[i]) - time(items[i - 1]));
  const TimeNs period = medianInPlace(&periods);
  return period > 0 ? 1 / toSeconds(period) : 0;
}

}  // namespace

std::vector<TurnPair> TurningCheck::aligned(const imu::ImuBuffer& readings,
                                            const ClockFit& clock) const {
  std::vector<TurnPair> out;
  for (const ImageTurn& turn : turns_) {
    TurnPair pair;
    pair.t0 = turn.t0;
    pair.t1 = turn.t1;
    const double dt = toSeconds(turn.t1 - turn.t0);
    if (dt <= 0 ||
        !readings.meanGyro(clock.onImuClock(turn.t0), clock.onImuClock(turn.t1), &pair.gyro_B)) {
      continue;
    }
    pair.image_C = turn.rotation_C / dt;
    out.push_back(pair);
  }
  return out;
}

TurningVerdict TurningCheck::verdict(const Mat3& R_B_C, double time_offset_s) const {
  TurningVerdict out;
  std::vector<TurnPair> turning = thatTurn(pairs_);
  if (turning.size() < kFewest) {
    out.findings = {hardlyTurns(turning.size(), pairs_.size(), camera_label_)};
    return out;
  }
  const double ratio = ratioOf(turning);
  out.findings = unitFindings(ratio, imu_label_);
  const bool degrees = inDegrees(ratio);
  out.gyro_trusted = out.findings.empty();
  if (!out.gyro_trusted && !degrees) return out;
  imu::ImuBuffer readings;
  ClockFit clock;
  clock.offset_s = time_offset_s;
  if (degrees) {
    for (TurnPair& p : turning) p.gyro_B /= kDegPerRad;
  } else {
    for (const ImuSample& s : beside_) readings.add(s);
    const ClockFit found = fitClock(turns_, readings, R_B_C);
    const auto clocks = clockFindings(
        found, time_offset_s, rateOf(turns_, [](const ImageTurn& t) { return t.t1; }),
        rateOf(beside_, [](const ImuSample& s) { return s.t; }), camera_label_, imu_label_);
    out.findings.insert(out.findings.end(), clocks.begin(), clocks.end());
    if (found.ok || found.runs_apart) {
      clock = found;
      turning = thatTurn(aligned(readings, clock));
    }
  }
  const AxesFit fit = fitAxes(turning);
  const double share_given = restOf(turning, R_B_C.transpose());
  const auto axes = axesFindings(fit, share_given, R_B_C, camera_label_, imu_label_);
  out.findings.insert(out.findings.end(), axes.begin(), axes.end());
  out.gyro_trusted = out.gyro_trusted && axes.empty();
  if (!axes.empty()) {
    if (!degrees) judgeCamera(turning, readings, clock, R_B_C, &out);
    return out;
  }
  const auto force_with = [&](const Mat3& R) {
    if (degrees) return ForceSign{};
    std::vector<ImuSample> samples = beside_;
    const Vec3 bias = biasWith(turning, R.transpose());
    for (ImuSample& sample : samples) sample.gyro -= bias;
    std::vector<ImageTurn> turns = turns_;
    for (ImageTurn& turn : turns) {
      turn.t0 = clock.onImuClock(turn.t0);
      turn.t1 = clock.onImuClock(turn.t1);
    }
    return forceSign(turns, samples, R, 0);
  };
  judgeRotation(fit, share_given, R_B_C, camera_label_, force_with, &out);
  if (out.R_B_C) out.force = force_with(*out.R_B_C);
  if (!degrees) judgeCamera(turning, readings, clock, R_B_C, &out);
  return out;
}

/// With the rotation found, or where turning has not confirmed any (a wrong lens may be why) with
/// the one given: then only what explains it counts.
void TurningCheck::judgeCamera(std::vector<TurnPair> turning, const imu::ImuBuffer& readings,
                               const ClockFit& clock, const Mat3& R_B_C_given,
                               TurningVerdict* out) const {
  const bool contradicted = !out->R_B_C && worst(out->findings) != Severity::note;
  const bool confirmed = out->R_B_C.has_value();
  const Mat3 R_C_B = out->R_B_C.value_or(R_B_C_given).transpose();
  const double ratio = ratioOf(turning);
  const bool ratio_fits = ratio > kLeastRatio && ratio < kMostRatio;
  Vec3 bias = clock.gyro_bias;
  if (!clock.ok || !ratio_fits) {
    const double scale = ratio_fits ? 1 : ratio;
    for (TurnPair& p : turning) p.gyro_B /= scale;
    bias = scale * biasWith(turning, R_C_B);
  }
  const auto by_gyro = [&](const ImageTurn& turn) -> std::optional<Mat3> {
    Vec3 rate;
    const TimeNs t0 = clock.onImuClock(turn.t0), t1 = clock.onImuClock(turn.t1);
    if (!readings.meanGyro(t0, t1, &rate)) return std::nullopt;
    return expSO3(R_C_B * (rate - bias) * toSeconds(t1 - t0));
  };
  const LensFit lens = fitLens(turns_, by_gyro, camera_);
  if (lens.other_told) {
    // What else turning says was seen through a lens that is not this one.
    *out = TurningVerdict{};
    out->findings = {otherModelFinding(lens, camera_->distortion, camera_label_)};
    return;
  }
  if (contradicted) return;
  const auto camera = cameraFinding(lens, confirmed ? ratio : 1, camera_label_);
  if (camera) out->findings.push_back(*camera);
  if (!confirmed) return;
  out->gyro_bias = bias;
  if (bias.norm() > kSmallBias) out->findings.push_back(biasFinding(bias, imu_label_));
  if (camera || !ratio_fits) return;
  const auto noise = stampNoise(turning, R_C_B, bias, camera_label_);
  if (noise) out->findings.push_back(*noise);
}

}  // namespace vir::check
