/// What may be wrong with a calibration of two cameras that their images contradict.
#include <algorithm>
#include <cmath>

#include "rig_fit.h"
#include "text.h"
#include "vir/core/angles.h"

namespace vir::check {
namespace {

constexpr double kTurnedDeg = 2.5;  ///< that an estimator corrects by itself
/// Nearer than this two cameras are at one place.
constexpr double kSamePlace_m = 1e-3;

double angleDeg(const Mat3& R) { return logQuat(Quat(R)).norm() * 180 / kPi; }

/// The same camera without its lens: as rectified images would be seen.
CameraCalibration withoutLens(CameraCalibration c) {
  c.distortion = Distortion::none;
  c.dist.fill(0);
  return c;
}

bool hasLens(const CameraCalibration& c) {
  return std::any_of(c.dist.begin(), c.dist.end(), [](double d) { return std::abs(d) > 0.01; });
}

Pose moved(const Pose& T, const Eigen::Matrix<double, 6, 1>& d) {
  return {(T.q * expQuat(Vec3(d.tail<3>()))).normalized(), T.p + d.head<3>()};
}

/// How the matches have the second camera stand to the first, the baseline's length as it was:
/// Gauss-Newton from where the calibration has it, believing ever less in those that are far off.
Pose foundMounting(const std::vector<std::array<Vec3, 2>>& rays, const Pose& T_0_1,
                   double focal_px) {
  using Vec6 = Eigen::Matrix<double, 6, 1>;
  constexpr double kStep = 1e-6;
  const double length = T_0_1.p.norm();
  Pose T = T_0_1;
  for (double scale_px = 64; scale_px >= kNearLinePx; scale_px /= 1.4) {
    const double scale = scale_px / focal_px;
    Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Identity() * 1e-9;
    Vec6 b = Vec6::Zero();
    for (const auto& r : rays) {
      const double e = offLine(r, T);
      Vec6 J;
      for (int k = 0; k < 6; ++k) J[k] = (offLine(r, moved(T, kStep * Vec6::Unit(k))) - e) / kStep;
      const double w = 1 / std::pow(1 + e * e / (scale * scale), 2);
      H += w * J * J.transpose();
      b += w * e * J;
    }
    H.topLeftCorner<3, 3>() += 1e-3 * H.norm() * T.p * T.p.transpose() / (length * length);
    T = moved(T, -H.ldlt().solve(b));
    if (!T.p.allFinite() || T.p.norm() < 1e-6 * length) return T_0_1;
    T.p *= length / T.p.norm();
  }
  return T;
}

}  // namespace

/// By the calibration there is nothing between the cameras; what they see is apart all the same.
Finding RigCheck::samePlace(const std::vector<Rays>& plain, const Fit& given) const {
  const std::string &first = cameras_[0].label, &second = cameras_[1].label;
  return {Severity::doubtful,
          "rig_same_place",
          second,
          "by the calibration it is where " + first + " is, and what they see says otherwise",
          num(100 * (1 - given.share)) + " % of " + std::to_string(plain.size()) +
              " matches are not seen in the same direction by both",
          "give the place of " + second + " (T_BS, T_cn_cnm1, or " + first + " to " + second +
              " in /tf_static)"};
}

/// The calibration does not fit: what would? Nothing where nothing does much better: repeated
/// texture matches wrongly as well.
std::optional<Finding> RigCheck::faultOf(const std::vector<Rays>& plain, const Fit& given) const {
  const std::string &first = cameras_[0].label, &second = cameras_[1].label;
  const Pose T_0_1 = cameras_[0].T_B_C.inverse() * cameras_[1].T_B_C;
  const std::string of = "of " + std::to_string(given.of) + " matches between the images, " +
                         num(100 * given.share) + " % lie where the calibration has them";
  const double wanted = std::max(kGood, given.share + kBetterBy);
  const auto fault = [&](const char* kind, double share, const std::string& what,
                         const std::string& remedy) {
    return Finding{Severity::doubtful,
                   kind,
                   second,
                   what,
                   of + ", so taken " + num(100 * share) + " %",
                   remedy};
  };
  if (T_0_1.p.norm() < kSamePlace_m) return samePlace(plain, given);
  const Pose &T_B_0 = cameras_[0].T_B_C, &T_B_1 = cameras_[1].T_B_C;
  const double mirrored = fitOf(plain, {T_0_1.q, -T_0_1.p}).share;
  const double second_inverted = fitOf(plain, T_B_0.inverse() * T_B_1.inverse()).share;
  const double both_inverted = fitOf(plain, T_B_0 * T_B_1.inverse()).share;
  const double inverted = fitOf(plain, T_0_1.inverse()).share;
  const double swapped = fitOf(raysOf({models_[1].get(), models_[0].get()}), T_0_1.inverse()).share;
  double rectified = 0;
  if (hasLens(cameras_[0].calibration) || hasLens(cameras_[1].calibration)) {
    const auto bare0 = camera::makeCamera(withoutLens(cameras_[0].calibration));
    const auto bare1 = camera::makeCamera(withoutLens(cameras_[1].calibration));
    const Pose side_by_side{Quat::Identity(), Vec3(T_0_1.p.norm(), 0, 0)};
    rectified = fitOf(raysOf({bare0.get(), bare1.get()}), side_by_side).share;
  }
  const double best =
      std::max({inverted, swapped, rectified, mirrored, second_inverted, both_inverted});
  if (best >= wanted && best == rectified) {
    return fault("rig_rectified", best,
                 "the images are rectified already, and the calibration is that of the raw ones",
                 "record the raw images, or give the calibration of the rectified ones (no "
                 "distortion, projection matrix P)");
  }
  constexpr double kAlike = 0.1;  // two cameras of one kind, side by side
  if (best >= wanted && swapped > best - kAlike) {
    const std::string or_pose =
        inverted > swapped - kAlike ? ", or the pose of " + second + " is the wrong way round" : "";
    return fault("rig_swapped", best,
                 "the images of " + first + " and " + second + " are swapped" + or_pose,
                 "give their topics or folders the other way round; T_cn_cnm1 of Kalibr takes "
                 "points of the camera before to this one");
  }
  if (best >= wanted && inverted < best - kAlike) {
    if (mirrored == best) {
      return fault("rig_mirrored", best,
                   "the way from " + first + " to " + second + " has the wrong sign",
                   "negate the translation of " + second + " against " + first +
                       " (T_cn_cnm1, or what T_BS of the two differ by), and leave the rotation");
    }
    const bool both = both_inverted == best;
    return fault(
        "rig_inverted", best,
        both ? "the poses of " + first + " and " + second + " in the body are the wrong way round"
             : "the pose of " + second + " in the body is the wrong way round",
        "invert " + std::string(both ? "them" : "it") +
            ": T_BS and T_B_C take points of the camera to the body, T_cam_imu of "
            "Kalibr those of the body to the camera");
  }
  if (best >= wanted) {
    return fault("rig_inverted", best,
                 "the pose of " + second + " against " + first + " is the wrong way round",
                 "invert it: T_cn_cnm1 of Kalibr takes points of the camera before to this one, "
                 "T_BS and T_B_C those of the camera to the body");
  }
  const Pose found = foundMounting(plain, T_0_1, focalPx());
  const double share = fitOf(plain, found).share;
  if (share < wanted) return std::nullopt;
  const double by = angleDeg(T_0_1.R().transpose() * found.R());
  const double baseline =
      std::acos(std::clamp(found.p.normalized().dot(T_0_1.p.normalized()), -1.0, 1.0)) * 180 / kPi;
  Finding out = fault(
      "rig_geometry", share,
      "the cameras do not stand to each other quite as the calibration says: " + second +
          " is turned by another " + num(by) + " deg, the way to it by " + num(baseline) + " deg",
      "calibrate " + first + " and " + second + " together");
  if (by < kTurnedDeg) {
    out.severity = Severity::note;
    out.remedy += "; `calibrate = online` finds so much by itself";
  }
  return out;
}

}  // namespace vir::check
