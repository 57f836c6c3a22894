#pragma once
/// Small scenes and cameras for the renderer's tests.
#include <Eigen/Dense>
#include <memory>
#include <vector>

#include "vir/rendering/scene.h"
#include "vir/rendering/scene_renderer.h"

namespace vir_test {

inline vir::rendering::Box room() { return {vir::Vec3(-4, -4, -1.5), vir::Vec3(8, 4, 2.5)}; }

/// One crate 3 m ahead of the origin, one 5 m ahead to the left.
inline std::vector<vir::rendering::Box> crates() {
  return {{vir::Vec3(3, -0.5, -0.6), vir::Vec3(3.8, 0.45, 0.5)},
          {vir::Vec3(5, 2.0, -1.0), vir::Vec3(6, 3.2, 0.8)}};
}

inline std::shared_ptr<const vir::rendering::Scene> twoCrates() {
  return std::make_shared<vir::rendering::Scene>(room(), crates());
}

inline vir::CameraCalibration calibration(vir::Distortion kind) {
  vir::CameraCalibration c;
  c.width = 376;
  c.height = 240;
  c.fx = 229.3;
  c.fy = 228.6;
  c.cx = 183.6;
  c.cy = 124.2;
  c.distortion = kind;
  if (kind == vir::Distortion::radtan) c.dist = {-0.28, 0.074, 2e-4, 2e-5, 0.0};
  if (kind == vir::Distortion::equidistant) c.dist = {0.0035, 7e-4, -2e-3, 2e-4, 0.0};
  return c;
}

/// Looks along x of W from `p`, image right is -y, turned by `theta` [rad] in the camera frame.
inline vir::Pose lookingAhead(const vir::Vec3& p, const vir::Vec3& theta = vir::Vec3::Zero()) {
  vir::Mat3 R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {(vir::Quat(R) * vir::expQuat(theta)).normalized(), p};
}

inline vir::rendering::FloatImage rendered(vir::rendering::SceneRenderer* renderer,
                                           const vir::Pose& T_W_C, double contrast = 1) {
  vir::rendering::FloatImage out;
  renderer->add(T_W_C, contrast, 1.0F, &out);
  return out;
}

}  // namespace vir_test
