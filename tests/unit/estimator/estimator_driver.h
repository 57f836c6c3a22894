#pragma once
/// Feeds an estimator with a standing camera's images and readings, from a seed.
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "vir/estimator/visual_inertial_estimator.h"

namespace vir_test {

constexpr vir::TimeNs kMs = 1000000;
constexpr int kWidth = 320, kHeight = 240;

/// Smoothed noise: full of corners.
inline cv::Mat texture(unsigned seed) {
  cv::Mat small(kHeight / 8, kWidth / 8, CV_8UC1), out;
  std::mt19937 random(seed);
  for (int y = 0; y < small.rows; ++y) {
    for (int x = 0; x < small.cols; ++x) {
      small.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(random() % 256);
    }
  }
  cv::resize(small, out, cv::Size(kWidth, kHeight), 0, 0, cv::INTER_CUBIC);
  return out;
}

struct EstimatorDriver {
  explicit EstimatorDriver(unsigned seed = 1, const vir::estimator::EstimatorConfig& config = {})
      : estimator(config), random(seed), image(texture(seed)) {
    vir::CameraCalibration c;
    c.width = kWidth;
    c.height = kHeight;
    c.fx = c.fy = 250;
    c.cx = kWidth / 2.0;
    c.cy = kHeight / 2.0;
    // The identity would say that nobody knows it.
    estimator.setCamera(c, {vir::Quat::Identity(), vir::Vec3(0.01, 0, 0)});
  }

  void imuAt(vir::TimeNs t) {
    const auto n = [&](double s) {
      const double x = normal(random), y = normal(random), z = normal(random);
      return vir::Vec3(s * x, s * y, s * z);
    };
    estimator.addImu({t, vir::Vec3(0.01, 0, -0.02) + n(0.002), vir::Vec3(0, 0, 9.81) + n(0.03)});
  }
  /// Readings every 5 ms in (from, to].
  void imu(vir::TimeNs from, vir::TimeNs to) {
    for (vir::TimeNs t = from + 5 * kMs; t <= to; t += 5 * kMs) imuAt(t);
  }
  /// Readings and images (every 50 ms) in (from, to].
  void run(vir::TimeNs from, vir::TimeNs to) {
    for (vir::TimeNs t = from + 50 * kMs; t <= to; t += 50 * kMs) {
      imu(t - 50 * kMs, t);
      estimator.addImage(t, image);
    }
  }

  vir::estimator::VisualInertialEstimator estimator;
  std::mt19937 random;
  std::normal_distribution<double> normal;
  cv::Mat image;
};

inline bool finite(const vir::StateEstimate& e) {
  const vir::State& s = e.state;
  return s.T_W_B.p.allFinite() && s.T_W_B.q.coeffs().allFinite() && s.v.allFinite() &&
         s.bg.allFinite() && s.ba.allFinite() && std::isfinite(e.reprojection_rms);
}

}  // namespace vir_test
