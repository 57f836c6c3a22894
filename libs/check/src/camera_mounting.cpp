#include "camera_mounting.h"

#include <array>
#include <cmath>

#include "text.h"
#include "vir/core/angles.h"

namespace vir::check {
namespace {

constexpr double kNear = 15;  // [deg]

double angleDeg(const Mat3& R) { return kDegPerRad * logSO3(R).norm(); }

/// A way to get the rotation wrong: found = given with the camera's axes turned by `turn`.
struct Slip {
  Mat3 turn = Mat3::Identity();
  const char* kind = "";
  std::string what, remedy;
  bool mirror = false;
};

Mat3 halfTurn(const Vec3& axis) {
  return 2.0 * axis.normalized() * axis.normalized().transpose() - Mat3::Identity();
}

/// Half a turn about an axis in the image is what mirrored images look like as well: the mirror
/// turned inside out. Only the direction of motion tells them apart.
Slip mirrorOrBack(const Vec3& axis, const char* mirrored, const char* negated, int force_sign) {
  Slip slip{halfTurn(axis), "images_mirrored", std::string("its images are mirrored ") + mirrored,
            "turn off the flip in the camera's driver, or mirror them back before importing", true};
  const std::string back = std::string("its pose on the IMU has ") + negated +
                           " the other way (as OpenGL and some tools have)";
  const std::string fix = "give the pose for axes x right, y down, z forward";
  if (force_sign > 0) {
    slip = {slip.turn, "camera_rotation", back, fix, false};
  } else if (force_sign == 0) {
    slip.what += ", or " + back;
    slip.remedy += "; or " + fix;
  }
  return slip;
}

}  // namespace

std::string axesNamed(const Mat3& M) {
  static const char* const axes = "xyz";
  std::string out;
  for (int r = 0; r < 3; ++r) {
    Eigen::Index c = 0;
    if (M.row(r).cwiseAbs().maxCoeff(&c) < 0.9) return {};
    out += std::string(out.empty() ? "" : ", ") + axes[r] + " is " + (M(r, c) < 0 ? "-" : "") +
           axes[c];
  }
  return out;
}

MountingFault mountingFault(const Mat3& given, const Mat3& found, int force_sign,
                            const std::string& camera_label, const std::string& evidence) {
  const Mat3 turn = given.transpose() * found;
  const std::array<Slip, 6> slips{
      Slip{given.transpose() * given.transpose(), "camera_pose_inverted",
           "its pose on the IMU is given the wrong way round",
           "give the inverse (T_BS takes camera to body; Kalibr's T_cam_imu the other way)", false},
      Slip{halfTurn(Vec3::UnitZ()), "camera_upside_down",
           "it is mounted upside down against the pose given, or its images are turned by half",
           "negate the first two columns of the rotation in T_BS, or turn the images back", false},
      mirrorOrBack(Vec3::UnitX(), "left to right", "y and z", force_sign),
      mirrorOrBack(Vec3::UnitY(), "top to bottom", "x and z", force_sign),
      mirrorOrBack(Vec3(1, 1, 0), "along a diagonal (rows for columns)", "its axes", force_sign),
      mirrorOrBack(Vec3(1, -1, 0), "along a diagonal (rows for columns)", "its axes", force_sign)};
  const Slip* nearest = nullptr;
  double off = kNear;
  std::string also;
  for (const Slip& s : slips) {
    const double angle = angleDeg(s.turn.transpose() * turn);
    if (angle < off) {
      if (nearest != nullptr) also = nearest->what;
      nearest = &s;
      off = angle;
    } else if (angle < kNear) {
      also = s.what;
    }
  }
  MountingFault out;
  out.finding = {Severity::unusable, "camera_rotation",
                 camera_label,       "",
                 evidence,           "give the pose of the camera on the IMU anew"};
  if (nearest == nullptr) {
    const std::string axes = axesNamed(given * found.transpose());
    out.finding.what = "its rotation on the IMU is not the one given" +
                       (axes.empty() ? std::string() : ", or the IMU's axes are: " + axes);
    return out;
  }
  out.finding.kind = nearest->kind;
  out.finding.what = nearest->what + (also.empty() ? "" : "; less likely: " + also);
  out.finding.remedy = nearest->remedy;
  if (nearest->kind == std::string("camera_pose_inverted")) {
    out.images_mirrored = nearest->mirror;
    return out;
  }
  // The IMU turned against what the pose is meant for looks the same where their axes are parallel.
  for (int k = 0; k < 3; ++k) {
    if (angleDeg(halfTurn(Vec3::Unit(k)) * found * given.transpose()) > kNear) continue;
    out.finding.what += "; or the IMU's axes are: " + axesNamed(given * found.transpose()) +
                        (k == 0 ? " (z down, as in NED, where the pose is meant for z up)" : "");
    out.finding.remedy += "; or turn the readings of the IMU";
  }
  out.images_mirrored = nearest->mirror;
  return out;
}

}  // namespace vir::check
