#pragma once
/// Keyframes of a made-up place as a robot would remember them: rendered images, landmarks with
/// noisy distances, poses that are exact.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "vir/camera/camera_model.h"
#include "vir/core/random.h"
#include "vir/places/describer.h"
#include "vir/rendering/camera_simulator.h"
#include "vir/rendering/scene.h"
#include "vir/types/loop.h"
#include "vir/vision/corner_detector.h"

namespace vir_test {

/// EuRoC's left camera, at `scale` of its size.
inline vir::CameraCalibration eurocCamera(double scale = 1) {
  vir::CameraCalibration c;
  c.width = static_cast<int>(752 * scale);
  c.height = static_cast<int>(480 * scale);
  c.fx = 458.654 * scale;
  c.fy = 457.296 * scale;
  c.cx = 367.215 * scale;
  c.cy = 248.375 * scale;
  c.distortion = vir::Distortion::radtan;
  c.dist = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0};
  return c;
}

/// The camera looks along the body's x, its image's right is the body's -y.
inline vir::Pose cameraInBody() {
  vir::Mat3 R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {vir::Quat(R), vir::Vec3(0.05, 0.02, -0.01)};
}

/// Level but for `roll` and `pitch`.
inline vir::Pose bodyAt(const vir::Vec3& p, double yaw, double pitch = 0, double roll = 0) {
  return {vir::Quat(vir::rotZ(yaw)) * vir::expQuat(vir::Vec3(0, pitch, 0)) *
              vir::expQuat(vir::Vec3(roll, 0, 0)),
          p};
}

/// Where a ray from inside the room meets something [m].
inline double distanceAlong(const vir::rendering::Scene& scene, const vir::Vec3& eye,
                            const vir::Vec3& ray) {
  const auto crossing = [&](const vir::rendering::Box& box, bool inside) {
    double enter = 0, leave = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      const double a = (box.low[k] - eye[k]) / ray[k], b = (box.high[k] - eye[k]) / ray[k];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    if (inside) return leave;
    return enter < leave ? enter : std::numeric_limits<double>::infinity();
  };
  double nearest = crossing(scene.interior(), true);
  for (const auto& box : scene.boxes()) nearest = std::min(nearest, crossing(box, false));
  return nearest;
}

class PlaceMaker {
 public:
  PlaceMaker(std::shared_ptr<const vir::rendering::Scene> scene,
             const vir::CameraCalibration& calibration,
             const vir::rendering::CameraSimulationOptions& camera, int surface_seed = 1,
             const vir::places::DescriberOptions& describer = {})
      : scene_(std::move(scene)),
        camera_(vir::camera::makeCamera(calibration)),
        simulator_(camera, scene_, camera_, surface_seed),
        describer_(describer, camera_),
        random_(static_cast<std::uint64_t>(camera.seed), 77) {}

  double distance_sigma = 0.03;  ///< relative, of a landmark's distance
  int landmarks = 100;

  const vir::rendering::GrayImage& take(const vir::Pose& T_W_B, double s = 1) {
    const vir::Pose T_W_C = T_W_B * cameraInBody();
    return simulator_.take(s, number_++, [&](double) { return T_W_C; });
  }

  std::shared_ptr<vir::PlaceKeyframe> keyframe(std::uint64_t id, vir::TimeNs t,
                                               const vir::Pose& T_W_B) {
    return describe(take(T_W_B, std::fmod(vir::toSeconds(t), 1000)), id, t, T_W_B);
  }

  std::shared_ptr<vir::PlaceKeyframe> describe(const vir::rendering::GrayImage& image,
                                               std::uint64_t id, vir::TimeNs t,
                                               const vir::Pose& T_W_B) {
    auto k = std::make_shared<vir::PlaceKeyframe>();
    k->id = id;
    k->t = t;
    k->T_W_B = T_W_B;
    k->T_B_C = cameraInBody();
    const vir::Pose T_W_C = T_W_B * cameraInBody();
    k->points = describer_.points(viewOf(image), T_W_C.q, seen(image, T_W_C));
    return k;
  }

  /// As LoopFinder asks it.
  std::vector<int> compare(const vir::rendering::GrayImage& image, const vir::Pose& T_W_B,
                           const std::vector<vir::places::ExpectedPoint>& expected) {
    return describer_.compare(viewOf(image), (T_W_B * cameraInBody()).q, expected);
  }

  std::vector<vir::places::SeenLandmark> seen(const vir::rendering::GrayImage& image,
                                              const vir::Pose& T_W_C) {
    const cv::Mat gray(image.height, image.width, CV_8UC1,
                       const_cast<std::uint8_t*>(image.pixels.data()));
    cv::Mat gradient[2], both;
    cv::Scharr(gray, gradient[0], CV_16S, 1, 0);
    cv::Scharr(gray, gradient[1], CV_16S, 0, 1);
    cv::merge(gradient, 2, both);
    vir::vision::CornerDetector detector({60, 25, 20, 12});
    std::vector<vir::places::SeenLandmark> out;
    for (const cv::Point2f& p : detector.detect(both, {}, landmarks)) {
      const vir::Vec2 px(p.x, p.y);
      vir::Vec3 ray;
      if (!camera_->unproject(px, &ray)) continue;
      const double rho = 1 / distanceAlong(*scene_, T_W_C.p, T_W_C.q * ray);
      const double sigma = distance_sigma * rho;
      out.push_back({px, std::max(1e-3, rho + sigma * random_.normal()), sigma});
    }
    return out;
  }

  const std::shared_ptr<const vir::camera::CameraModel>& camera() const { return camera_; }

 private:
  static vir::Image viewOf(const vir::rendering::GrayImage& image) {
    vir::Image view;
    view.width = image.width;
    view.height = image.height;
    view.pixels = image.pixels.data();
    return view;
  }

  std::shared_ptr<const vir::rendering::Scene> scene_;
  std::shared_ptr<const vir::camera::CameraModel> camera_;
  vir::rendering::CameraSimulator simulator_;
  vir::places::Describer describer_;
  vir::Random random_;
  std::uint64_t number_ = 0;
};

}  // namespace vir_test
