#include <cmath>
#include <stdexcept>

#include "models.h"

namespace vir::camera {

double positiveUpTo(const std::function<double(double)>& slope, double x_max) {
  constexpr int kSteps = 20000;
  double lo = 0.0;
  for (int i = 1; i <= kSteps; ++i) {
    double hi = x_max * i / kSteps;
    if (slope(hi) > 0.0) {
      lo = hi;
      continue;
    }
    for (int k = 0; k < 60; ++k) {
      const double mid = 0.5 * (lo + hi);
      (slope(mid) > 0.0 ? lo : hi) = mid;
    }
    return lo;
  }
  return x_max;
}

double turningPoint(const std::vector<double>& coefficients, double x_max) {
  return positiveUpTo(
      [&](double x) {
        double s = 1.0;
        double power = 1.0;
        for (std::size_t i = 0; i < coefficients.size(); ++i) {
          power *= x * x;
          s += static_cast<double>(2 * i + 3) * coefficients[i] * power;
        }
        return s;
      },
      x_max);
}

namespace {
/// No lens is described by more; pixels stay numbers.
constexpr double kLargest = 1e12;

void require(bool ok, const std::string& name, double value, const std::string& allowed) {
  if (ok) return;
  throw std::invalid_argument("camera calibration: " + name + " = " + std::to_string(value) +
                              " must be " + allowed);
}
}  // namespace

std::shared_ptr<const CameraModel> makeCamera(const CameraCalibration& c) {
  require(c.width > 0, "width", c.width, "a positive number of pixels");
  require(c.height > 0, "height", c.height, "a positive number of pixels");
  require(c.fx > 0 && c.fx < kLargest, "fx", c.fx, "a positive focal length in pixels");
  require(c.fy > 0 && c.fy < kLargest, "fy", c.fy, "a positive focal length in pixels");
  require(std::abs(c.cx) < kLargest, "cx", c.cx, "finite");
  require(std::abs(c.cy) < kLargest, "cy", c.cy, "finite");
  for (std::size_t i = 0; i < c.dist.size(); ++i) {
    require(std::abs(c.dist[i]) < kLargest, "distortion coefficient " + std::to_string(i),
            c.dist[i], "finite");
  }
  switch (c.distortion) {
    case Distortion::equidistant:
      return std::make_shared<EquidistantCamera>(c);
    case Distortion::double_sphere:
      require(c.dist[0] > -1, "xi", c.dist[0], "above -1");
      require(c.dist[1] >= 0 && c.dist[1] <= 1, "alpha", c.dist[1], "between 0 and 1");
      return std::make_shared<DoubleSphereCamera>(c);
    case Distortion::omni:
      require(c.dist[0] >= 0, "xi", c.dist[0], "not negative");
      return std::make_shared<OmniCamera>(c);
    case Distortion::none:
    case Distortion::radtan:
    case Distortion::rational:
      break;
  }
  return std::make_shared<PinholeCamera>(c);
}

}  // namespace vir::camera
