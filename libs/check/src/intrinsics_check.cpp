#include "vir/check/intrinsics_check.h"

#include <algorithm>

#include "text.h"

namespace vir::check {
namespace {

/// Of the image's width: a fisheye whose circle fills the height of a wide image has 0.15, a lens
/// that sees 3 deg has 19.
constexpr double kShortest = 0.1, kLongest = 20;

}  // namespace

std::optional<Finding> intrinsicsFinding(const CameraCalibration& c,
                                         const std::string& camera_label) {
  if (c.width <= 0 || c.height <= 0) return std::nullopt;
  const double shortest = std::min(c.fx, c.fy), longest = std::max(c.fx, c.fy);
  const bool too_short = !(shortest >= kShortest * c.width);
  const bool too_long = !(longest <= kLongest * c.width);
  const bool outside = !(c.cx >= 0 && c.cx <= c.width && c.cy >= 0 && c.cy <= c.height);
  if (!too_short && !too_long && !outside) return std::nullopt;
  const bool of_width = too_short && longest < 20;
  Finding f{Severity::unusable, "camera_intrinsics", camera_label, "", "", ""};
  f.what = too_short || too_long ? std::string("its focal length is far too ") +
                                       (too_short ? "short" : "long") + " for its images"
                                 : "its centre lies outside of its images";
  f.evidence = "intrinsics fx " + num(c.fx, 6) + ", fy " + num(c.fy, 6) + ", cx " + num(c.cx, 6) +
               ", cy " + num(c.cy, 6) + " for images of " + std::to_string(c.width) + "x" +
               std::to_string(c.height);
  f.remedy = of_width ? "give them in pixels (are they in units of the image's width and height?)"
                      : "give them in pixels, of images of this size (a decimal point missing, or "
                        "micrometres?)";
  return f;
}

std::optional<Finding> mountingFinding(double lever_m, const std::string& camera_label) {
  constexpr double kFarthest = 3;
  if (!(lever_m > kFarthest)) return std::nullopt;
  return Finding{Severity::unusable,
                 "camera_pose_far",
                 camera_label,
                 "its pose on the IMU is " + num(lever_m, 6) + " m away from it",
                 "translation of T_BS, T_cam_imu",
                 "give it in metres (millimetres?)"};
}

}  // namespace vir::check
