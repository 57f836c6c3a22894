#include "vir/check/rig_check.h"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <optional>

#include "rig_fit.h"
#include "text.h"
#include "vir/core/order_statistics.h"

namespace vir::check {
namespace {

/// Images farther apart are not of one instant.
constexpr TimeNs kApart = 30'000'000;
constexpr TimeNs kEvery = 400'000'000;
constexpr int kPairs = 60, kLeastPairs = 5;
constexpr int kCorners = 500;
constexpr std::size_t kFewMatches = 100;  ///< of all pairs together
/// What is closer to the horizon of its line than this says nothing of before or behind.
constexpr double kParallaxPx = 3;
constexpr double kLittleParallaxPx = 1.2;
constexpr long kFewBehind = 50;
constexpr double kBrighter = 1.8;
/// The cameras are apart by more or less than given by such a share, as sure as so many sigmas.
constexpr double kLengthOff = 0.1, kSure = 4;
constexpr int kLeastSteps = 5;

}  // namespace

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
  RigLength::Sights sights;
  sights.t = waiting_[0].t;
  waiting_ = {};
  if (descriptors[0].empty() || descriptors[1].empty()) return;
  std::vector<cv::DMatch> found;
  cv::BFMatcher(cv::NORM_HAMMING, true).match(descriptors[0], descriptors[1], found);
  const auto at = [](const cv::KeyPoint& p) {
    return Vec2(static_cast<double>(p.pt.x), static_cast<double>(p.pt.y));
  };
  for (const cv::DMatch& m : found) {
    if (m.distance > kMostBits) continue;
    matches_.push_back({{at(corners[0][static_cast<std::size_t>(m.queryIdx)]),
                         at(corners[1][static_cast<std::size_t>(m.trainIdx)])}});
    sights.both.push_back(matches_.back().px);
    sights.descriptors.push_back(descriptors[0].row(m.queryIdx));
  }
  for (const cv::KeyPoint& p : corners[0]) sights.corners.push_back(at(p));
  sights.corner_descriptors = descriptors[0];
  length_.add(std::move(sights));
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
  long before = 0, behind = 0, behind_unsaid = 0;
  for (const Rays& r : rays) {
    const double off = focalPx() * std::abs(std::asin(std::clamp(offLine(r, T_0_1), -1.0, 1.0)));
    distances.push_back(off);
    if (off > kNearLinePx) continue;
    // Distances along both rays: l0 ray0 - l1 ray1 = t.
    const Vec3 ray1 = T_0_1.R() * r[1];
    const Vec3 across = r[0].cross(ray1);
    const double parallax = focalPx() * across.norm();
    const double l0 = T_0_1.p.cross(ray1).dot(across), l1 = T_0_1.p.cross(r[0]).dot(across);
    const bool in_front = l0 > 0 && l1 > 0;
    if (parallax > kLittleParallaxPx) ++(in_front ? before : behind);
    if (parallax > kParallaxPx && !in_front) continue;
    behind_unsaid += parallax > kLittleParallaxPx && !in_front ? 1 : 0;
    parallaxes.push_back(parallax);
  }
  if (distances.empty()) return out;
  // Of a far place every match has little parallax: then most of them decide.
  const long fit = static_cast<long>(parallaxes.size()) -
                   (behind > kFewBehind && behind > 2 * before ? behind_unsaid : 0);
  out.share = static_cast<double>(fit) / static_cast<double>(rays.size());
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

Finding RigCheck::unexplained(const Fit& given) const {
  // Repeated texture matches wrongly as well.
  const bool by_chance = given.share < kChance;
  return {
      by_chance ? Severity::doubtful : Severity::note,
      "rig_geometry",
      cameras_[1].label,
      "what it and " + cameras_[0].label +
          (by_chance ? " see does not lie" : " see lies only in part") +
          " in the directions that the calibration says, nor in those of any mistake that is "
          "known",
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

/// The directions fit: does the length?
Finding RigCheck::lengthFinding(const Fit& given, const BodyPath& path) const {
  const Pose T_0_1 = cameras_[0].T_B_C.inverse() * cameras_[1].T_B_C;
  const RigLength::Result length = length_.compare({models_[0].get(), models_[1].get()},
                                                   cameras_[0].T_B_C, T_0_1, focalPx(), path);
  const double given_m = T_0_1.p.norm();
  const std::string found = num(given_m * length.times, 4) + " +- " +
                            num(given_m * length.sigma, 2) + " m apart by the ground truth (" +
                            std::to_string(length.steps) + " steps), given " + num(given_m, 4) +
                            " m";
  const bool told = length.steps >= kLeastSteps && length.sigma < kLengthOff * length.times;
  const double off = std::abs(std::log(length.times));
  if (told && off > kLengthOff && off > kSure * length.sigma / length.times) {
    return {Severity::doubtful,
            "rig_length",
            cameras_[1].label,
            "it is " + num(length.times) + " times as far from " + cameras_[0].label +
                " as the calibration says",
            found,
            "correct the length of its translation against " + cameras_[0].label +
                " (the size of the calibration's board? another unit?), or the scale of the "
                "ground truth"};
  }
  return {
      Severity::note,
      "rig",
      cameras_[1].label,
      "what it and " + cameras_[0].label + " see lies in the directions that the calibration says",
      num(100 * given.share) + " % of " + std::to_string(given.of) + " matches fit, median " +
          num(given.median_px, 2) + " px from their line, parallax " + num(given.parallax_px) +
          " px; " +
          (told ? found
                : "how far the cameras are apart cannot be judged without a true path along "
                  "which they move"),
      ""};
}

std::vector<Finding> RigCheck::findings(const BodyPath& path) const {
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
    if (overlap && given.share < kGood && out.size() == light) out.push_back(unexplained(given));
    return out;
  }
  out.push_back(lengthFinding(given, path));
  return out;
}

}  // namespace vir::check
