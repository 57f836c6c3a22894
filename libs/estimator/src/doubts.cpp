#include "doubts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace vir::estimator {
namespace {

/// Mean squares, whitened: good recordings stay below 0.5 (readings) and 1.3 (sights), whatever
/// they were recorded with; those with a wrong calibration, unit or axis go beyond.
constexpr double kInertial = 1.5, kReprojection = 2.6;
constexpr double kGoodInertial = 0.5, kGoodReprojection = 1.3;
constexpr double kLeastInflation = 4;
/// A single bad solution, as when motion begins, is not a level: no more than this counts of it.
constexpr double kMostOfOne = 9;
/// Share of the tracks that are landmarks, while moving: good ones have more than 0.4.
constexpr double kFewSeen = 0.12;
constexpr int kTracksThatCount = 30;
constexpr double kMovesMps = 0.1;
/// New values count by this: about ten keyframes, or twenty images.
constexpr double kShareOfKeyframe = 0.1, kShareOfImage = 0.05;
constexpr int kFewestKeyframes = 8, kFewestImages = 40;
/// On readings alone for longer, the position is worth a doubt whatever comes after [s].
constexpr double kBlindS = 1.5;
/// Velocity beside that of the positions, over a second, and per speed [m/s, 1]: good recordings
/// stay below 0.24, most below 0.1.
constexpr double kAgainstPath = 0.3, kAgainstPathPerSpeed = 0.1;
/// Images further apart say nothing of it [s].
constexpr double kBetweenImagesS = 0.2;
/// Sigmas of the prior: a gain that is further off is only found in part, and the scale suffers.
constexpr double kGainBeyondPrior = 6;
constexpr double kBiasAcc = 1.2, kBiasGyro = 0.3;

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", x);
  return text;
}

}  // namespace

template <typename Text>
void Doubts::raiseIf(bool bad, TimeNs t, const char* kind, const Text& made) {
  if (!bad) return;
  const std::string text = made();
  if (current_.empty()) current_ = text;
  add(kind, t, text);
}

void Doubts::add(const std::string& kind, TimeNs t, const std::string& text) {
  const auto [at, fresh] = known_.emplace(kind, texts_.size());
  if (fresh) texts_.push_back(text + " (from " + elapsed_.text(t) + " on)");
}

void Doubts::addCause(const std::string& kind, TimeNs t, const std::string& text) {
  const std::size_t before = texts_.size();
  add(kind, t, text);
  if (texts_.size() > before) std::rotate(texts_.begin(), texts_.end() - 1, texts_.end());
}

void Doubts::restarted(TimeNs t, const std::string& why) {
  add("restart", t, "started anew on the way (" + why + "): what came before is not tied to it");
  inertial_ = reprojection_ = seen_ = Level();
  before_ = State();
  against_path_.setZero();
  compared_ = 0;
  blind_since_ = 0;
}

/// The readings make the velocity, the images hold the positions: where the robot moves with all
/// that is seen, they come apart.
void Doubts::compareVelocity(const StateEstimate& e) {
  const State now = e.state;
  const double dt = toSeconds(now.t - before_.t);
  if (before_.t != 0 && dt > 0 && dt < kBetweenImagesS) {
    const Vec3 path = (now.T_W_B.p - before_.T_W_B.p) / dt;
    against_path_ += kShareOfImage * (0.5 * (before_.v + now.v) - path - against_path_);
    ++compared_;
    const double by = against_path_.norm();
    const bool apart =
        compared_ >= kFewestImages && by > kAgainstPath + kAgainstPathPerSpeed * path.norm();
    raiseIf(apart, now.t, "velocity", [&] {
      return "the readings of the IMU move by " + number(by) +
             " m/s against what is seen: a lift or a vehicle that moves with it, a camera that "
             "hangs, or a blow";
    });
  }
  before_ = now;
}

void Doubts::look(const StateEstimate& e, const Evidence& evidence) {
  current_.clear();
  compareVelocity(e);
  if (evidence.full && e.inertial_rms > 0) {
    inertial_.add(std::min(kMostOfOne, e.inertial_rms * e.inertial_rms), kShareOfKeyframe);
  }
  if (evidence.full && e.reprojection_rms > 0) {
    reprojection_.add(std::min(kMostOfOne, e.reprojection_rms * e.reprojection_rms),
                      kShareOfKeyframe);
  }
  const bool moving = e.health != Health::standing;
  // What is seen after a rest has no depth yet, nor will it have before there is some motion.
  if (!moving) seen_ = Level();
  if (moving && e.state.v.norm() > kMovesMps && e.tracks >= kTracksThatCount) {
    seen_.add(static_cast<double>(e.landmarks) / e.tracks, kShareOfImage);
  }
  const TimeNs t = e.state.t;
  const bool inertial_bad = inertial_.count >= kFewestKeyframes && inertial_.value > kInertial;
  raiseIf(inertial_bad, t, "inertial", [&] {
    return "the readings of the IMU do not fit the images (" + number(std::sqrt(inertial_.value)) +
           " sigma): calibration, units or axes may be wrong";
  });
  const bool sights_bad =
      reprojection_.count >= kFewestKeyframes && reprojection_.value > kReprojection;
  raiseIf(sights_bad, t, "sights", [&] {
    return "the sights contradict each other (" + number(std::sqrt(reprojection_.value)) +
           " sigma): calibration of the camera, its clock, or things that move";
  });
  const bool few_seen = seen_.count >= kFewestImages && moving && seen_.value < kFewSeen;
  raiseIf(few_seen, t, "seen", [&] {
    return "few tracks fit the motion: " + std::to_string(e.landmarks) + " landmarks of " +
           std::to_string(e.tracks) + " tracks";
  });
  lookAtCalibration(e, evidence.acc_gain);
  const bool blind = evidence.blind && moving;
  if (!blind || blind_since_ == 0) blind_since_ = t;
  const double blind_s = toSeconds(t - blind_since_);
  raiseIf(blind && blind_s > kBlindS, t, "blind",
          [&] { return "no landmarks for " + number(blind_s) + " s, IMU only"; });
  if (blind && current_.empty()) current_ = "no landmarks, IMU only";
}

/// What is found on the way must be plausible.
void Doubts::lookAtCalibration(const StateEstimate& e, double acc_gain) {
  const TimeNs t = e.state.t;
  raiseIf(acc_gain > kGainBeyondPrior, t, "acc_gain", [&] {
    return "the accelerometer's gain is off by " + number(acc_gain) +
           " sigmas of what was assumed ([Window] acc_gain_sigma): a wrong scale or unit; where "
           "it is true, give [Imu] acc_gain or a larger sigma";
  });
  raiseIf(e.state.ba.norm() > kBiasAcc, t, "bias_acc", [&] {
    return "an accelerometer bias of " + number(e.state.ba.norm()) +
           " m/s^2 is not plausible: units, axes or calibration may be wrong";
  });
  raiseIf(e.state.bg.norm() > kBiasGyro, t, "bias_gyro", [&] {
    return "a gyro bias of " + number(e.state.bg.norm()) +
           " rad/s is not plausible: units, axes or calibration may be wrong";
  });
}

double Doubts::inflation() const {
  if (current_.empty()) return 1;
  return std::max(
      {kLeastInflation, inertial_.value / kGoodInertial, reprojection_.value / kGoodReprojection});
}

std::vector<std::string> Doubts::all() const { return texts_; }

}  // namespace vir::estimator
