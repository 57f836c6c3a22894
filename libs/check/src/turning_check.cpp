#include "vir/check/turning_check.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>

#include "camera_mounting.h"
#include "text.h"
#include "vir/core/angles.h"
#include "vir/core/order_statistics.h"
#include "vir/initialization/image_turn.h"

namespace vir::check {
namespace {

constexpr std::size_t kFewest = 30;  // pairs that turn, to say anything
constexpr double kTurning = 0.08;    // [rad/s] by images, to count as turning
constexpr std::size_t kMostPairs = 20000, kMostMatched = 2000;
constexpr double kWrongAngle = 15;  // [deg] between rotation found and given
constexpr std::size_t kMostReadings = 400'000;
constexpr double kReachS = 0.2;  // offsets of the clocks looked for, to both sides
constexpr double kTurnS = 0.09;  // over less than this, noise makes turns of steps aside
constexpr double kLongestTurnS = 0.3;
constexpr double kOffsetS = 0.004;  // that no estimate of a window needs to be told
/// Turning about other axes, below which one rotation is as good as another.
constexpr double kFewAxes = 0.15;
constexpr double kWrongShare = 0.8;  // left unexplained by what is given, which then is wrong
constexpr double kFits = 0.45;       // rest of the rate that a rotation leaves, as a share

/// Rotation (or mirror) from the gyro's axes to the camera's that explains the pairs best.
struct AxesFit {
  Mat3 rotation = Mat3::Identity(), mirror = Mat3::Identity();
  double rotation_rest = 1, mirror_rest = 1;  ///< median share of the rate left unexplained
  double second_axis = 0;                     ///< how much turning there is about other axes, 0..1
};

double restOf(const std::vector<TurnPair>& pairs, const Mat3& R_C_B) {
  std::vector<double> rest;
  for (const TurnPair& p : pairs) {
    const double size = std::max(p.image_C.norm(), p.gyro_B.norm());
    rest.push_back((p.image_C - R_C_B * p.gyro_B).norm() / size);
  }
  return medianInPlace(&rest);
}

AxesFit fitAxes(const std::vector<TurnPair>& pairs) {
  Mat3 sum = Mat3::Zero();
  for (const TurnPair& p : pairs) {
    // Directions weighted by the rate, so that outliers of one image do not decide.
    const double weight = 1 / std::max(p.image_C.norm(), p.gyro_B.norm());
    sum += weight * p.image_C * p.gyro_B.transpose();
  }
  const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Mat3 free = svd.matrixU() * svd.matrixV().transpose();
  const double sign = free.determinant() < 0 ? -1 : 1;
  AxesFit fit;
  fit.rotation = svd.matrixU() * Vec3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  fit.mirror = svd.matrixU() * Vec3(1, 1, -sign).asDiagonal() * svd.matrixV().transpose();
  const Vec3 s = svd.singularValues();
  fit.second_axis = s(0) > 0 ? s(1) / s(0) : 0;
  fit.rotation_rest = restOf(pairs, fit.rotation);
  fit.mirror_rest = restOf(pairs, fit.mirror);
  return fit;
}

double angleDeg(const Mat3& R) { return kDegPerRad * logSO3(R).norm(); }

std::vector<TurnPair> thatTurn(const std::vector<TurnPair>& pairs) {
  std::vector<TurnPair> out;
  for (const TurnPair& p : pairs) {
    if (p.image_C.norm() > kTurning) out.push_back(p);
  }
  return out;
}

double ratioOf(const std::vector<TurnPair>& pairs) {
  std::vector<double> ratios;
  for (const TurnPair& p : pairs) ratios.push_back(p.gyro_B.norm() / p.image_C.norm());
  return medianInPlace(&ratios);
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

/// At which offset of the stamps of images gyro and images agree best.
initialization::TurnCorrelation correlate(const std::vector<ImageTurn>& turns_seen,
                                          const std::vector<ImuSample>& samples,
                                          const Mat3& R_B_C) {
  std::vector<initialization::ImageTurn> turns;
  for (std::size_t i = 0; i < turns_seen.size(); ++i) {
    // Put together from images that follow each other.
    Mat3 R = Mat3::Identity();
    std::size_t k = i;
    for (;; ++k) {
      R = R * expSO3(turns_seen[k].rotation_C);
      const bool linked = k + 1 < turns_seen.size() && turns_seen[k + 1].t0 == turns_seen[k].t1;
      if (toSeconds(turns_seen[k].t1 - turns_seen[i].t0) >= kTurnS || !linked) break;
    }
    const double span = toSeconds(turns_seen[k].t1 - turns_seen[i].t0);
    if (span < kTurnS || span > kLongestTurnS) continue;
    initialization::ImageTurn turn;
    turn.t0 = turns_seen[i].t0;
    turn.t1 = turns_seen[k].t1;
    turn.rate_C = logSO3(R) / span;
    // All alike; the correlation finds out how good they are.
    turn.information = Mat3::Identity() / (0.02 * 0.02);
    turns.push_back(turn);
  }
  imu::ImuBuffer readings;
  for (const ImuSample& s : samples) readings.add(s);
  return initialization::correlateTurns(turns, readings, Quat(R_B_C), {kReachS, 0.004});
}

std::vector<Finding> offsetFindings(const initialization::TurnCorrelation& found, double given_s,
                                    const std::string& camera_label) {
  if (!found.ok) return {};
  const double apart = found.offset_s - given_s;
  const std::string by = num(1e3 * std::abs(apart)) + " ms";
  const std::string evidence =
      "gyro and turning of the images agree best with " + num(1e3 * found.offset_s) + " +- " +
      num(1e3 * found.sigma_s, 2) + " ms added to the stamps of the images (" +
      std::to_string(found.turns) + " turns); given " + num(1e3 * given_s) + " ms";
  if (std::abs(apart) < kOffsetS || std::abs(apart) < 4 * found.sigma_s) {
    return {{Severity::note, "time_offset", camera_label, "its clock against the gyro's as found",
             evidence, ""}};
  }
  return {{Severity::doubtful, "time_offset", camera_label,
           std::string("its images are stamped ") + by + (apart < 0 ? " late" : " early"), evidence,
           "give it: timeshift_cam_imu in the calibration, or --set Camera.time_offset_s=" +
               num(found.offset_s) + "; `calibrate = online` finds the rest"}};
}

/// Reads as a gyro in deg/s.
bool inDegrees(double ratio) { return ratio > 20 && ratio < 160; }

/// What the share of turning that gyro and images see says of the gyro's unit and scale.
std::vector<Finding> scaleFindings(double ratio, const std::string& imu_label,
                                   const std::string& camera_label) {
  const std::string rates = "where the images turn by 1 rad/s the gyro says " + num(ratio);
  if (inDegrees(ratio)) {
    return {{Severity::unusable, "gyro_in_deg", imu_label, "the gyro is in deg/s, not in rad/s",
             rates, kDegreesRemedy}};
  }
  if (ratio < 0.5 || ratio > 2) {
    return {{Severity::unusable, "gyro_scale", imu_label,
             "gyro and images disagree on how fast it turns", rates,
             "check the gyro's unit and columns, and the camera's focal length"}};
  }
  if (ratio < 0.85 || ratio > 1.18) {
    // A gyro is right to some per cent, as long as its unit is.
    return {{Severity::doubtful, "camera_scale", camera_label,
             "its focal length or its lens model does not fit: the images turn " + num(1 / ratio) +
                 " times as fast as the gyro says",
             rates,
             "check intrinsics, lens model (radtan, equidistant, ...) and coefficients, and that "
             "they are for images of this size; else the gyro's scale"}};
  }
  return {};
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
                   : "one axis has the wrong sign, or two are exchanged"}};
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

}  // namespace

TurningVerdict TurningCheck::verdict(const Mat3& R_B_C, double time_offset_s) const {
  TurningVerdict out;
  std::vector<TurnPair> turning = thatTurn(pairs_);
  if (turning.size() < kFewest) {
    out.findings = {{Severity::note, "hardly_turns", camera_label_,
                     "turns too little to hold the gyro against it",
                     std::to_string(turning.size()) + " of " + std::to_string(pairs_.size()) +
                         " images turn faster than " + num(kTurning) + " rad/s",
                     ""}};
    return out;
  }
  const double ratio = ratioOf(turning);
  out.findings = scaleFindings(ratio, imu_label_, camera_label_);
  const bool degrees = inDegrees(ratio);
  out.gyro_trusted = worst(out.findings) != Severity::unusable;
  if (!out.gyro_trusted && !degrees) return out;
  double offset_s = time_offset_s;
  if (degrees) {
    for (TurnPair& p : turning) p.gyro_B /= kDegPerRad;
  } else {
    const auto found = correlate(turns_, beside_, R_B_C);
    const auto offset = offsetFindings(found, time_offset_s, camera_label_);
    out.findings.insert(out.findings.end(), offset.begin(), offset.end());
    if (found.ok) offset_s = found.offset_s;
    // What is explained by an offset is not a wrong rotation.
    if (!offset.empty() && offset[0].severity == Severity::doubtful) {
      out.R_B_C = R_B_C;
      out.force = forceSign(turns_, beside_, R_B_C, offset_s);
      return out;
    }
  }
  const AxesFit fit = fitAxes(turning);
  const double share_given = restOf(turning, R_B_C.transpose());
  const auto axes = axesFindings(fit, share_given, R_B_C, camera_label_, imu_label_);
  out.findings.insert(out.findings.end(), axes.begin(), axes.end());
  out.gyro_trusted = out.gyro_trusted && axes.empty();
  if (!axes.empty()) return out;
  const auto force_with = [&](const Mat3& R) {
    return degrees ? ForceSign{} : forceSign(turns_, beside_, R, offset_s);
  };
  judgeRotation(fit, share_given, R_B_C, camera_label_, force_with, &out);
  if (out.R_B_C) out.force = force_with(*out.R_B_C);
  return out;
}

}  // namespace vir::check
