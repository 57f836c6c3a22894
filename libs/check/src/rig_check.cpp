#include "vir/check/rig_check.h"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <optional>

#include "text.h"
#include "vir/core/angles.h"
#include "vir/core/order_statistics.h"

namespace vir::check {
namespace {

/// Images farther apart are not of one instant.
constexpr TimeNs kApart = 30'000'000;
constexpr TimeNs kEvery = 400'000'000;
constexpr int kPairs = 60, kLeastPairs = 5;
constexpr int kCorners = 500;
constexpr std::size_t kFewMatches = 100;  ///< of all pairs together
constexpr double kNearLinePx = 2;
/// What is closer to the horizon of its line than this says nothing of before or behind.
constexpr double kParallaxPx = 3;
/// Of matches that fit: a calibration that is right, one that another must be better than by so
/// much to be named, and what chance alone gives.
constexpr double kGood = 0.6, kBetterBy = 0.2, kChance = 0.2;
constexpr double kTurnedDeg = 2.5;  ///< that an estimator corrects by itself
constexpr double kBrighter = 1.8;

double angleDeg(const Mat3& R) { return logQuat(Quat(R)).norm() * 180 / kPi; }

/// Sine of the angle between the first ray and the plane of the second and the baseline.
double offLine(const std::array<Vec3, 2>& rays, const Pose& T_0_1) {
  const Vec3 normal = T_0_1.p.cross(T_0_1.R() * rays[1]);
  const double n = normal.norm();
  return n > 1e-9 ? rays[0].dot(normal) / n : 0;
}

/// The same camera without its lens: as rectified images would be seen.
CameraCalibration withoutLens(CameraCalibration c) {
  c.distortion = Distortion::none;
  c.dist.fill(0);
  return c;
}

bool hasLens(const CameraCalibration& c) {
  return std::any_of(c.dist.begin(), c.dist.end(), [](double d) { return std::abs(d) > 0.01; });
}

}  // namespace

struct RigCheck::Fit {
  std::size_t of = 0;      ///< matches whose rays the models know
  double share = 0;        ///< of them on their epipolar line and in front of both cameras
  double median_px = 0;    ///< distance from the line
  double parallax_px = 0;  ///< median of those that fit
};

RigCheck::RigCheck(RigCamera first, RigCamera second)
    : cameras_{std::move(first), std::move(second)} {
  for (std::size_t k = 0; k < 2; ++k) models_[k] = camera::makeCamera(cameras_[k].calibration);
}

bool RigCheck::wants(TimeNs t) const { return pairs_ < kPairs && t >= next_; }

void RigCheck::add(int camera, TimeNs t, const cv::Mat& gray) {
  if (!wants(t) || gray.empty() || gray.type() != CV_8UC1) return;
  waiting_[static_cast<std::size_t>(camera)] = {t, gray.clone()};
  pairUp();
}

void RigCheck::pairUp() {
  if (waiting_[0].gray.empty() || waiting_[1].gray.empty()) return;
  if (std::abs(waiting_[0].t - waiting_[1].t) > kApart) return;
  const auto orb = cv::ORB::create(kCorners);
  std::array<std::vector<cv::KeyPoint>, 2> corners;
  std::array<cv::Mat, 2> descriptors;
  for (std::size_t k = 0; k < 2; ++k) {
    orb->detectAndCompute(waiting_[k].gray, cv::noArray(), corners[k], descriptors[k]);
  }
  const auto light = [&](std::size_t k) { return std::max(1.0, cv::mean(waiting_[k].gray)[0]); };
  brighter_.push_back(light(1) / light(0));
  next_ = std::max(waiting_[0].t, waiting_[1].t) + kEvery;
  ++pairs_;
  waiting_ = {};
  if (descriptors[0].empty() || descriptors[1].empty()) return;
  std::vector<cv::DMatch> found;
  cv::BFMatcher(cv::NORM_HAMMING, true).match(descriptors[0], descriptors[1], found);
  constexpr float kBits = 50;
  for (const cv::DMatch& m : found) {
    if (m.distance > kBits) continue;
    const auto at = [](const cv::KeyPoint& p) {
      return Vec2(static_cast<double>(p.pt.x), static_cast<double>(p.pt.y));
    };
    matches_.push_back({{at(corners[0][static_cast<std::size_t>(m.queryIdx)]),
                         at(corners[1][static_cast<std::size_t>(m.trainIdx)])}});
  }
}

/// Does a fair part of the second camera's image show what the first sees, at some metres?
bool RigCheck::overlaps() const {
  constexpr double kDistance_m = 5;
  const Pose T_0_1 = cameras_[0].T_B_C.inverse() * cameras_[1].T_B_C;
  const CameraCalibration &c0 = cameras_[0].calibration, &c1 = cameras_[1].calibration;
  int seen = 0, all = 0;
  for (int y = 1; y < 8; ++y) {
    for (int x = 1; x < 8; ++x) {
      Vec3 ray;
      Vec2 px;
      ++all;
      if (!models_[1]->unproject({c1.width * x / 8.0, c1.height * y / 8.0}, &ray)) continue;
      if (!models_[0]->project(T_0_1 * (kDistance_m * ray), &px)) continue;
      seen += px.x() > 0 && px.y() > 0 && px.x() < c0.width && px.y() < c0.height ? 1 : 0;
    }
  }
  return 3 * seen >= all;
}

std::vector<RigCheck::Rays> RigCheck::raysOf(
    const std::array<const camera::CameraModel*, 2>& models) const {
  std::vector<Rays> out;
  for (const Match& m : matches_) {
    Rays rays;
    if (models[0]->unproject(m.px[0], &rays[0]) && models[1]->unproject(m.px[1], &rays[1])) {
      out.push_back(rays);
    }
  }
  return out;
}

RigCheck::Fit RigCheck::fitOf(const std::vector<Rays>& rays, const Pose& T_0_1) const {
  Fit out;
  out.of = rays.size();
  std::vector<double> distances, parallaxes;
  for (const Rays& r : rays) {
    const double off = focalPx() * std::abs(std::asin(std::clamp(offLine(r, T_0_1), -1.0, 1.0)));
    distances.push_back(off);
    if (off > kNearLinePx) continue;
    // Distances along both rays: l0 ray0 - l1 ray1 = t.
    const Vec3 ray1 = T_0_1.R() * r[1];
    const Vec3 across = r[0].cross(ray1);
    const double parallax = focalPx() * across.norm();
    const double l0 = T_0_1.p.cross(ray1).dot(across), l1 = T_0_1.p.cross(r[0]).dot(across);
    if (parallax > kParallaxPx && (l0 <= 0 || l1 <= 0)) continue;
    parallaxes.push_back(parallax);
  }
  if (distances.empty()) return out;
  out.share = static_cast<double>(parallaxes.size()) / static_cast<double>(rays.size());
  out.median_px = medianInPlace(&distances);
  if (!parallaxes.empty()) out.parallax_px = medianInPlace(&parallaxes);
  return out;
}

std::vector<Finding> RigCheck::lightFindings() const {
  std::vector<double> ratios = brighter_;
  const double ratio = medianInPlace(&ratios);
  if (ratio < kBrighter && ratio > 1 / kBrighter) return {};
  return {{Severity::note, "rig_exposure", cameras_[1].label,
           "it is exposed differently from " + cameras_[0].label,
           num(ratio) + " times as bright, median of " + std::to_string(pairs_) + " pairs",
           "couple the cameras' exposure and gain"}};
}

namespace {

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
  const double inverted = fitOf(plain, T_0_1.inverse()).share;
  const double swapped = fitOf(raysOf({models_[1].get(), models_[0].get()}), T_0_1.inverse()).share;
  double rectified = 0;
  if (hasLens(cameras_[0].calibration) || hasLens(cameras_[1].calibration)) {
    const auto bare0 = camera::makeCamera(withoutLens(cameras_[0].calibration));
    const auto bare1 = camera::makeCamera(withoutLens(cameras_[1].calibration));
    const Pose side_by_side{Quat::Identity(), Vec3(T_0_1.p.norm(), 0, 0)};
    rectified = fitOf(raysOf({bare0.get(), bare1.get()}), side_by_side).share;
  }
  const double best = std::max({inverted, swapped, rectified});
  if (best >= wanted && best == rectified) {
    return fault("rig_rectified", best,
                 "the images are rectified already, and the calibration is that of the raw ones",
                 "record the raw images, or give the calibration of the rectified ones (no "
                 "distortion, projection matrix P)");
  }
  constexpr double kAlike = 0.1;  // two cameras of one kind, side by side
  if (best >= wanted && swapped > inverted - kAlike) {
    const std::string or_pose =
        inverted > swapped - kAlike ? ", or the pose of " + second + " is the wrong way round" : "";
    return fault("rig_swapped", best,
                 "the images of " + first + " and " + second + " are swapped" + or_pose,
                 "give their topics or folders the other way round; T_cn_cnm1 of Kalibr takes "
                 "points of the camera before to this one");
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

Finding RigCheck::unexplained(const Fit& given) const {
  return {
      Severity::doubtful,
      "rig_geometry",
      cameras_[1].label,
      "what it and " + cameras_[0].label +
          " see does not lie in the directions that the calibration says, nor in those of any "
          "mistake that is known",
      "of " + std::to_string(given.of) + " matches between the images, " + num(100 * given.share) +
          " % do",
      "look at the poses of both cameras (T_BS takes the camera to the body), their lenses, and "
      "whether the images are of one time"};
}

Finding RigCheck::apart() const {
  return {Severity::note,
          "rig",
          cameras_[1].label,
          "by the calibration it looks elsewhere than " + cameras_[0].label +
              ", and the images do not contradict",
          std::to_string(pairs_) + " pairs of images",
          ""};
}

std::vector<Finding> RigCheck::findings() const {
  if (pairs_ < kLeastPairs) return {};
  std::vector<Finding> out;
  const bool overlap = overlaps();
  if (overlap) out = lightFindings();
  const std::size_t light = out.size();
  const Pose T_0_1 = cameras_[0].T_B_C.inverse() * cameras_[1].T_B_C;
  const auto rays = raysOf({models_[0].get(), models_[1].get()});
  if (matches_.size() < kFewMatches || rays.size() < kFewMatches) {
    if (!overlap) return {apart()};
    out.push_back({Severity::doubtful, "rig_no_matches", cameras_[1].label,
                   "its images show nothing of what " + cameras_[0].label +
                       " sees, and by the calibration they should",
                   std::to_string(matches_.size()) + " matches in " + std::to_string(pairs_) +
                       " pairs of images",
                   "look at both: is one covered, of another time, or mounted otherwise?"});
    return out;
  }
  const Fit given = fitOf(rays, T_0_1);
  if (given.share < kGood) {
    if (auto fault = faultOf(rays, given)) out.push_back(std::move(*fault));
    if (out.empty() && !overlap) out.push_back(apart());
    if (overlap && given.share < kChance && out.size() == light) out.push_back(unexplained(given));
    return out;
  }
  out.push_back(
      {Severity::note, "rig", cameras_[1].label,
       "what it and " + cameras_[0].label + " see lies in the directions that the calibration says",
       num(100 * given.share) + " % of " + std::to_string(given.of) + " matches fit, median " +
           num(given.median_px, 2) + " px from their line, parallax " + num(given.parallax_px) +
           " px; how far the cameras are apart is not tested by that",
       ""});
  return out;
}

}  // namespace vir::check
