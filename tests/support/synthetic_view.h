#pragma once
/// A textured plane seen by a moving camera, with the exact image of every point of it.
#include <Eigen/Dense>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "vir/camera/camera_model.h"
#include "vir/geometry/pose.h"

namespace vir::test {

/// Renders the plane z = 0 of W, which carries a seeded random texture, into any camera model.
class SyntheticPlane {
 public:
  /// `texel_m`: edge of a texel; the texture is smooth over about two texels.
  explicit SyntheticPlane(double texel_m = 0.004, int size = 2048, unsigned seed = 7)
      : texel_m_(texel_m) {
    cv::RNG random(seed);
    cv::Mat fine(size, size, CV_32F), coarse(size / 8, size / 8, CV_32F), large;
    random.fill(fine, cv::RNG::NORMAL, 0, 1);
    random.fill(coarse, cv::RNG::NORMAL, 0, 1);
    cv::GaussianBlur(fine, fine, cv::Size(), 2.0);
    cv::GaussianBlur(coarse, coarse, cv::Size(), 1.0);
    cv::resize(coarse, large, fine.size(), 0, 0, cv::INTER_CUBIC);
    // Both parts to about the same contrast.
    texture_ = 160.0 * fine + 70.0 * large + 120.0;
  }

  /// The image at camera pose T_W_C, in grey levels times `gain` plus `offset`, black off the
  /// plane.
  cv::Mat render(const camera::CameraModel& camera, const Pose& T_W_C, double gain = 1.0,
                 double offset = 0.0) const {
    const CameraCalibration& c = camera.calibration();
    cv::Mat image(c.height, c.width, CV_8UC1);
    for (int y = 0; y < c.height; ++y) {
      for (int x = 0; x < c.width; ++x) {
        Vec3 p;
        double grey = 0.0;
        if (meet(camera, T_W_C, Vec2(x, y), &p)) grey = gain * texture(p) + offset;
        image.at<uchar>(y, x) = cv::saturate_cast<uchar>(grey);
      }
    }
    return image;
  }

  /// Where a pixel of the view from T_W_C0 appears from T_W_C1.
  bool transfer(const camera::CameraModel& camera, const Pose& T_W_C0, const Pose& T_W_C1,
                const Vec2& px0, Vec2* px1) const {
    Vec3 p;
    return meet(camera, T_W_C0, px0, &p) && camera.project(T_W_C1.inverse() * p, px1);
  }

 private:
  static bool meet(const camera::CameraModel& camera, const Pose& T_W_C, const Vec2& px,
                   Vec3* p_W) {
    Vec3 b;
    if (!camera.unproject(px, &b)) return false;
    const Vec3 ray = T_W_C.q * b;
    const double depth = -T_W_C.p.z() / ray.z();
    if (!(depth > 0.0) || depth > 100.0) return false;
    *p_W = T_W_C.p + depth * ray;
    return true;
  }
  double texture(const Vec3& p) const {
    const double u = p.x() / texel_m_ + 0.5 * texture_.cols;
    const double v = p.y() / texel_m_ + 0.5 * texture_.rows;
    const int iu = static_cast<int>(std::floor(u)), iv = static_cast<int>(std::floor(v));
    if (iu < 0 || iv < 0 || iu + 1 >= texture_.cols || iv + 1 >= texture_.rows) return 0.0;
    const double a = u - iu, b = v - iv;
    const float* top = texture_.ptr<float>(iv) + iu;
    const float* low = texture_.ptr<float>(iv + 1) + iu;
    return (1 - b) * ((1 - a) * top[0] + a * top[1]) + b * ((1 - a) * low[0] + a * low[1]);
  }

  double texel_m_;
  cv::Mat texture_;
};

/// Looks down on the plane from `height_m`, turned by the rotation vector `theta` [rad] in the
/// camera frame.
inline Pose lookingDown(const Vec3& position, const Vec3& theta = Vec3::Zero()) {
  const Quat down(0.0, 1.0, 0.0, 0.0);  // half a turn about x: z forward points to -z of W
  return {down * expQuat(theta), position};
}

inline CameraCalibration smallCamera(Distortion kind = Distortion::radtan) {
  CameraCalibration c;
  c.width = 376;
  c.height = 240;
  c.fx = c.fy = 229.0;
  c.cx = 183.6;
  c.cy = 124.2;
  c.distortion = kind;
  if (kind == Distortion::radtan) c.dist = {-0.28, 0.074, 2e-4, 2e-5, 0.0};
  if (kind == Distortion::equidistant) c.dist = {0.0035, 7e-4, -2e-3, 2e-4, 0.0};
  return c;
}

}  // namespace vir::test
