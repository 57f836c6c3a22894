#include "vir/places/describer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "patch_angle.h"
#include "vir/places/hamming.h"
#include "vir/vision/corner_detector.h"

namespace vir::places {
namespace {

constexpr int kCell_px = 60;
/// The patch of a descriptor reaches this far.
constexpr int kReach_px = 15;
/// What is expected somewhere is looked for there and so far beside it: a descriptor bears half.
constexpr int kBeside_px = 3;

/// Where a descriptor's patch is in the image as a whole.
cv::Rect innerOf(const cv::Mat& gray) {
  const int margin = kReach_px + 1;
  if (gray.cols <= 2 * margin || gray.rows <= 2 * margin) return {};
  return {margin, margin, gray.cols - 2 * margin, gray.rows - 2 * margin};
}

bool isInside(const Vec2& px, const cv::Rect& inner) {
  return px.allFinite() &&
         inner.contains(cv::Point(static_cast<int>(std::clamp(px.x(), -1.0, 1e6)),
                                  static_cast<int>(std::clamp(px.y(), -1.0, 1e6))));
}

bool isLandmark(const SeenLandmark& l, const cv::Rect& inner) {
  return std::isfinite(l.inverse_distance) && std::isfinite(l.sigma) && isInside(l.px, inner);
}

}  // namespace

struct Describer::Impl {
  Impl(const DescriberOptions& o, std::shared_ptr<const camera::CameraModel> c)
      : options(o), camera(std::move(c)), detector(detectorOptions(o)) {
    orb = cv::ORB::create(o.points, 1.2f, 1, kReach_px, 0, 2, cv::ORB::HARRIS_SCORE,
                          2 * kReach_px + 1, 20);
  }
  static vision::DetectorOptions detectorOptions(const DescriberOptions& o) {
    vision::DetectorOptions d;
    d.cell_px = kCell_px;
    d.min_distance_px = o.min_distance_px;
    d.min_score = o.min_corner_score;
    d.border_px = kReach_px + 1;
    return d;
  }
  std::vector<cv::Point2f> corners(const cv::Mat& gray, const std::vector<cv::Point2f>& taken,
                                   int wanted);
  /// The image without a copy; empty if it is none, or not the camera's.
  cv::Mat usable(const Image& image, const Quat& R_W_C) const;
  /// Descriptors for points that have pixel and ray; which of them got one.
  std::vector<std::size_t> describe(const cv::Mat& gray, const Quat& R_W_C,
                                    std::vector<PlacePoint>* points);

  DescriberOptions options;
  std::shared_ptr<const camera::CameraModel> camera;
  vision::CornerDetector detector;
  cv::Ptr<cv::ORB> orb;
  cv::Mat dx, dy, gradient;  // scratch
};

std::vector<cv::Point2f> Describer::Impl::corners(const cv::Mat& gray,
                                                  const std::vector<cv::Point2f>& taken,
                                                  int wanted) {
  if (wanted <= 0) return {};
  cv::Scharr(gray, dx, CV_16S, 1, 0);
  cv::Scharr(gray, dy, CV_16S, 0, 1);
  const cv::Mat both[] = {dx, dy};
  cv::merge(both, 2, gradient);
  detector.reset();
  return detector.detect(gradient, taken, wanted);
}

cv::Mat Describer::Impl::usable(const Image& image, const Quat& R_W_C) const {
  const CameraCalibration& c = camera->calibration();
  if (!image.pixels || image.width != c.width || image.height != c.height) return {};
  if (!R_W_C.coeffs().allFinite()) return {};
  return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels),
          image.stride ? image.stride : static_cast<std::size_t>(image.width)};
}

std::vector<std::size_t> Describer::Impl::describe(const cv::Mat& gray, const Quat& R_W_C,
                                                   std::vector<PlacePoint>* points) {
  const Vec3 down_C = R_W_C.normalized().conjugate() * Vec3(0, 0, -1);
  std::vector<cv::KeyPoint> keypoints;
  for (std::size_t k = 0; k < points->size(); ++k) {
    const PlacePoint& p = (*points)[k];
    const double angle = patchAngle(gray, *camera, p, down_C, kReach_px);
    keypoints.emplace_back(cv::Point2f(p.px.x(), p.px.y()), static_cast<float>(2 * kReach_px + 1),
                           static_cast<float>(angle), 0.0f, 0, static_cast<int>(k));
  }
  cv::Mat descriptors;
  orb->compute(gray, keypoints, descriptors);
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < keypoints.size(); ++k) {
    out.push_back(static_cast<std::size_t>(keypoints[k].class_id));
    auto& descriptor = (*points)[out.back()].descriptor;
    std::memcpy(descriptor.data(), descriptors.ptr(static_cast<int>(k)), descriptor.size());
  }
  return out;
}

Describer::Describer(const DescriberOptions& options,
                     std::shared_ptr<const camera::CameraModel> camera) {
  options.validate();
  if (!camera) throw std::invalid_argument("a describer of places needs a camera");
  impl_ = std::make_unique<Impl>(options, std::move(camera));
}

Describer::~Describer() = default;

void Describer::setCamera(std::shared_ptr<const camera::CameraModel> camera) {
  if (camera) impl_->camera = std::move(camera);
}

std::vector<PlacePoint> Describer::points(const Image& image, const Quat& R_W_C,
                                          const std::vector<SeenLandmark>& landmarks) {
  const cv::Mat gray = impl_->usable(image, R_W_C);
  const cv::Rect inner = innerOf(gray);
  if (inner.empty()) return {};
  std::vector<PlacePoint> out;
  std::vector<cv::Point2f> at;
  const auto take = [&](const cv::Point2f& px, double inverse_distance, double sigma) {
    Vec3 ray;
    if (!impl_->camera->unproject(Vec2(px.x, px.y), &ray)) return;
    PlacePoint p;
    p.px = Eigen::Vector2f(px.x, px.y);
    p.ray_C = ray.cast<float>();
    p.inverse_distance = static_cast<float>(inverse_distance);
    p.inverse_distance_sigma = static_cast<float>(sigma);
    out.push_back(p);
    at.push_back(px);
  };
  const auto full = [&] { return static_cast<int>(out.size()) >= impl_->options.points; };
  for (const SeenLandmark& l : landmarks) {
    if (full()) break;
    if (!isLandmark(l, inner)) continue;
    const bool known = l.inverse_distance > 0 && l.sigma > 0;
    take(cv::Point2f(static_cast<float>(l.px.x()), static_cast<float>(l.px.y())),
         known ? l.inverse_distance : 0, known ? l.sigma : 0);
  }
  const int wanted = impl_->options.points - static_cast<int>(out.size());
  for (const cv::Point2f& px : impl_->corners(gray, at, wanted)) take(px, 0, 0);

  std::vector<PlacePoint> described;
  for (const std::size_t k : impl_->describe(gray, R_W_C, &out)) described.push_back(out[k]);
  return described;
}

std::vector<int> Describer::compare(const Image& image, const Quat& R_W_C,
                                    const std::vector<ExpectedPoint>& expected) {
  std::vector<int> out(expected.size(), -1);
  const cv::Mat gray = impl_->usable(image, R_W_C);
  const cv::Rect inner = innerOf(gray);
  if (inner.empty()) return out;
  std::vector<PlacePoint> points;
  std::vector<std::size_t> of;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    Vec2 at;
    if (!expected[k].ray_C.allFinite() || !impl_->camera->project(expected[k].ray_C, &at)) continue;
    for (const int dx : {-kBeside_px, 0, kBeside_px}) {
      for (const int dy : {-kBeside_px, 0, kBeside_px}) {
        PlacePoint p;
        const Vec2 px = at + Vec2(dx, dy);
        Vec3 ray;
        if (!isInside(px, inner) || !impl_->camera->unproject(px, &ray)) continue;
        p.px = px.cast<float>();
        p.ray_C = ray.cast<float>();
        points.push_back(p);
        of.push_back(k);
      }
    }
  }
  for (const std::size_t k : impl_->describe(gray, R_W_C, &points)) {
    const int bits = hammingDistance(points[k].descriptor, expected[of[k]].descriptor);
    int& least = out[of[k]];
    if (least < 0 || bits < least) least = bits;
  }
  return out;
}

void setRays(const camera::CameraModel& camera, std::vector<PlacePoint>* points) {
  for (PlacePoint& p : *points) {
    Vec3 ray;
    if (camera.unproject(p.px.cast<double>(), &ray)) p.ray_C = ray.cast<float>();
  }
}

double raysMoved(const camera::CameraModel& a, const camera::CameraModel& b) {
  const CameraCalibration& c = a.calibration();
  double most = 0;
  for (const double x : {0.1, 0.5, 0.9}) {
    for (const double y : {0.1, 0.5, 0.9}) {
      const Vec2 px(x * c.width, y * c.height);
      Vec3 of_a, of_b;
      if (!a.unproject(px, &of_a) || !b.unproject(px, &of_b)) continue;
      most = std::max(most, c.fx * (of_a - of_b).norm());
    }
  }
  return most;
}

}  // namespace vir::places
