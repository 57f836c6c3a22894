/// A calibration with the camera turned by tens of degrees, or given the wrong way round, never
/// starts: where no start succeeds, turning tells the rotation from nothing.
#include <algorithm>
#include <cmath>

#include "back_end.h"

namespace vir::estimator {
namespace {

constexpr int kImagesPerLook = 10;
/// What the window cannot take for itself any more [rad].
constexpr double kTurned = 0.35;
/// As near as this to a rotation is that rotation [rad].
constexpr double kTheSame = 0.15;
/// Of a camera whose position in the body is not known [m].
constexpr double kPositionUnknown = 0.1;

double angleBetween(const Quat& a, const Quat& b) { return logQuat(a.conjugate() * b).norm(); }

}  // namespace

void BackEnd::checkCameraRotation(TimeNs t) {
  if (turned || !timing || timing->settled() || ++images_since_rotation < kImagesPerLook) return;
  images_since_rotation = 0;
  const initialization::CameraRotation found = timing->rotation(imu);
  const double off = angleBetween(T_B_C.q, found.q_B_C);
  if (!found.ok || off < std::max(kTurned, 6 * found.sigma_rad)) return;
  turned = true;
  const Pose inverse = T_B_C.inverse();
  const bool inverted = angleBetween(inverse.q, found.q_B_C) < kTheSame;
  const auto degrees = std::lround(off * 180 / 3.14159265358979323846);
  const std::string text =
      inverted ? "the camera's pose in the body seems to be given the wrong way round (T_C_B for "
                 "T_B_C): its inverse is used"
               : "the camera seems turned by " + std::to_string(degrees) +
                     " deg against its calibration: the rotation that turning shows is used";
  warn(text);
  doubts.add("camera_rotation", t, text);
  T_B_C = inverted ? inverse : Pose{found.q_B_C, T_B_C.p};
  Calibration now = given;
  now.T_B_C = T_B_C;
  now.time_offset_s = time_offset_s;
  window->setCalibration(now);
  window->setExtrinsicsSigma(inverted ? 0 : kPositionUnknown, inverted ? 0 : 2 * found.sigma_rad);
  startup = std::make_unique<Startup>(config.startup, config.imu, T_B_C, focalPx());
}

}  // namespace vir::estimator
