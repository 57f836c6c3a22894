#include "patch_angle.h"

#include <Eigen/Geometry>
#include <cmath>

#include "vir/core/angles.h"

namespace vir::places {
namespace {

/// Sine of the angle between ray and vertical below which "down" is no direction in the image.
constexpr double kSteep = 0.35;

double degrees(double y, double x) {
  const double angle = std::atan2(y, x) * 180 / kPi;
  return angle < 0 ? angle + 360 : angle;
}

/// Direction from the point to the centre of brightness.
double brightSide(const cv::Mat& gray, int cx, int cy, int reach) {
  std::int64_t mx = 0, my = 0;
  for (int y = -reach; y <= reach; ++y) {
    const std::uint8_t* row = gray.ptr(cy + y);
    const int half = static_cast<int>(std::sqrt(reach * reach - y * y));
    for (int x = -half; x <= half; ++x) {
      mx += x * row[cx + x];
      my += y * row[cx + x];
    }
  }
  return degrees(static_cast<double>(my), static_cast<double>(mx));
}

}  // namespace

double patchAngle(const cv::Mat& gray, const camera::CameraModel& camera, const PlacePoint& point,
                  const Vec3& down_C, int reach_px) {
  const Vec3 ray = point.ray_C.cast<double>();
  const Vec3 across = down_C - ray * ray.dot(down_C);
  Vec2 px;
  Mat23 J;
  if (across.norm() > kSteep && camera.project(ray, &px, &J)) {
    const Vec2 down = J * across;
    if (down.squaredNorm() > 0) return degrees(down.y(), down.x());
  }
  return brightSide(gray, cvRound(point.px.x()), cvRound(point.px.y()), reach_px);
}

}  // namespace vir::places
