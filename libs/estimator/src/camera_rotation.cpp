/// A calibration with the camera turned by tens of degrees, given the wrong way round or not at all
/// never starts in motion, and starts at rest without a word: turning tells the rotation from
/// nothing.
#include <algorithm>
#include <cmath>

#include "back_end.h"
#include "vir/core/angles.h"

namespace vir::estimator {
namespace {

constexpr int kImagesPerLook = 10;
/// What the window cannot take for itself any more [rad].
constexpr double kTurned = 0.35;
/// As near as this to a rotation is that rotation [rad].
constexpr double kTheSame = 0.15;
/// Of a camera whose position in the body is not known [m], and of one that was not even given
/// [m, rad].
constexpr double kPositionUnknown = 0.1;
constexpr double kPositionNotGiven = 0.2, kRotationNotGiven = 0.1;
/// Share of the turning that a rotation must explain beyond what another does.
constexpr double kClearly = 0.3;
/// MRPT's poses come and go by angles [m, or of a quaternion].
constexpr double kIdentity = 1e-9;

/// Half a turn about an axis of the image is how a mirror turns, too.
constexpr double kHalfTurn = kPi - 0.15;

double angleBetween(const Quat& a, const Quat& b) { return logQuat(a.conjugate() * b).norm(); }

/// What else the images of a camera that seems turned by `turn` (in its own frame) may be: those of
/// a mirror turn as if about its axis, which only a scene with depth tells apart.
std::string orMirrored(const Vec3& turn) {
  if (turn.norm() < kHalfTurn) return "";
  const Vec3 axis = turn.normalized().cwiseAbs();
  constexpr double kAlong = 0.97;
  if (axis.z() > kAlong) return "; are its images upside down?";
  if (axis.x() > kAlong) return "; are its images mirrored (left for right)?";
  if (axis.y() > kAlong) return "; are its images mirrored (top for bottom)?";
  return "";
}

}  // namespace

void BackEnd::expectUnknownPose() {
  pose_unknown = T_B_C.p.norm() < kIdentity && T_B_C.q.vec().norm() < kIdentity;
  if (!pose_unknown) return;
  warn(
      "the camera's pose in the body is not given (it is the identity): it is found on the way, "
      "which takes a start in motion with turns; give it, or calibrate once (vir-slam calibrate "
      "camera)");
  window->setExtrinsicsSigma(kPositionNotGiven, kRotationNotGiven);
  // At rest any rotation would do.
  StartupOptions moving = config.startup;
  moving.allow_standing = false;
  startup = std::make_unique<Startup>(moving, config.imu, T_B_C, focalPx());
}

void BackEnd::checkCameraRotation(TimeNs t) {
  if (turned || !timing || timing->rotationKnown()) return;
  if (++images_since_rotation < kImagesPerLook) return;
  images_since_rotation = 0;
  const initialization::CameraRotation found = timing->rotation(imu);
  const double off = angleBetween(T_B_C.q, found.q_B_C);
  if (!found.ok) return;
  if (off < std::max(kTurned, 6 * found.sigma_rad)) {
    timing->setRotationKnown();
    return;
  }
  // What runs is only given up for what is clearly better.
  if (running && timing->explainedBy(T_B_C.q, imu) > found.explained - kClearly) return;
  turned = true;
  const bool inverted = angleBetween(T_B_C.q.conjugate(), found.q_B_C) < kTheSame;
  tellRotation(t, inverted, logQuat(T_B_C.q.conjugate() * found.q_B_C));
  if (running) {
    // It began at rest, where any rotation fits.
    if (!recent.empty()) origin = recent.front().T_W_B;
    restart("the camera is turned");
    if (long_window.anchors().empty()) long_window.clear();
  }
  T_B_C = inverted ? T_B_C.inverse() : Pose{found.q_B_C, T_B_C.p};
  Calibration now = given;
  now.T_B_C = T_B_C;
  now.time_offset_s = time_offset_s;
  window->setCalibration(now);
  const double position = pose_unknown ? kPositionNotGiven : kPositionUnknown;
  window->setExtrinsicsSigma(inverted ? 0 : position, inverted ? 0 : 2 * found.sigma_rad);
  startup = std::make_unique<Startup>(config.startup, config.imu, T_B_C, focalPx());
}

void BackEnd::tellRotation(TimeNs t, bool inverted, const Vec3& turn) {
  if (pose_unknown) {
    warn("the camera's rotation in the body was found from its turning");
    return;
  }
  const auto degrees = std::lround(turn.norm() * 180 / kPi);
  const std::string text =
      inverted ? "the camera's pose in the body seems to be given the wrong way round (T_C_B for "
                 "T_B_C): its inverse is used"
               : "the camera seems turned by " + std::to_string(degrees) +
                     " deg against its calibration: the rotation that turning shows is used" +
                     orMirrored(turn);
  warn(text);
  doubts.addCause("camera_rotation", t, text);
}

}  // namespace vir::estimator
