/// Settings of both windows.
#include "vir/core/choice.h"
#include "vir/core/option_check.h"
#include "vir/window/long_window.h"
#include "vir/window/short_window.h"

namespace vir::window {

void describe(OptionVisitor& v, WindowOptions& o) {
  v.section("Window", "The short window: keyframes, solver, marginalisation");
  v.value("keyframes", o.keyframes, {4, 40}, "keyframes kept besides the newest image");
  v.value("iterations", o.iterations, {1, 100}, "solver iterations per keyframe");
  v.value("iterations_newest", o.iterations_newest, {1, 100},
          "solver iterations for an image that is no keyframe");
  v.value("newest_frames", o.newest_frames, {1, 10},
          "frames that move with an image that is no keyframe");
  v.value("full_every_image", o.full_every_image,
          "solve the whole window for every image, not only for keyframes");
  v.value("sigma_px", o.sigma_px, {0.01, 100.0}, "noise of a tracked feature [px]");
  chooseEnum(v, "loss", o.loss, {"huber", "cauchy"}, "robust loss of reprojections");
  v.value("loss_scale", o.loss_scale, {0.1, 1e6},
          "reprojections beyond this many sigma weigh less");
  v.value("outlier_sigma", o.outlier_sigma, {1.0, 1e6}, "reprojections beyond are dropped [sigma]");
  v.value("keyframe_parallax_px", o.keyframe_parallax_px, {0.5, 500.0},
          "mean parallax to the last keyframe that makes the next");
  v.value("keyframe_min_shared", o.keyframe_min_shared, {0.0, 1.0},
          "share of tracks the last keyframe must have seen, else a new one is made");
  v.value("keyframe_max_interval_s", o.keyframe_max_interval_s, {0.05, 60.0},
          "longest time between keyframes while moving");
  v.value("min_parallax_px", o.min_parallax_px, {0.1, 100.0},
          "parallax a track needs before it gets a depth");
  v.value("first_estimate_jacobians", o.first_estimate_jacobians,
          "Jacobians of states in the prior are taken at their first estimate");
  v.value("extrinsics_sigma_m", o.calibration.position_m, {1e-6, 10.0},
          "how far the given camera position may be off");
  v.value("extrinsics_sigma_rad", o.calibration.rotation_rad, {1e-6, 3.0},
          "how far the given camera rotation may be off");
  v.value("time_offset_sigma_s", o.calibration.time_offset_s, {1e-7, 1.0},
          "how far the time offset may be off once the start has found it");
  v.value("time_offset_walk", o.time_offset_walk, {0.0, 0.01},
          "how much the time offset wanders: clocks run at rates of their own [s/sqrt(s)]");
  v.value("readout_s", o.readout_s, {-0.2, 0.2},
          "rolling shutter: time from the first row of an image to the last");
  v.value("readout_sigma_s", o.calibration.readout_s, {1e-7, 0.2}, "how far readout_s may be off");
  v.value("focal_sigma", o.calibration.focal, {1e-6, 0.5},
          "how far the given focal lengths may be off (relative)");
  v.value("aspect_sigma", o.calibration.aspect, {1e-6, 0.5},
          "how far the ratio of the focal lengths may be off (relative)");
  v.value("centre_sigma_px", o.calibration.centre_px, {1e-4, 1000.0},
          "how far the given principal point may be off");
  v.value("distortion_sigma", o.calibration.distortion, {1e-7, 1.0},
          "how far k1 and k2 of the lens (xi and alpha of a double sphere) may be off");
  chooseEnum(
      v, "lens", o.lens, {"watched", "free", "given"},
      "k1 and k2: as given until the images are sure that they are others, estimated from the "
      "first image on, or as given whatever the images say");
  v.value("gyro_gain_sigma", o.calibration.gyro_gain, {1e-7, 0.5},
          "how far the gyro's gain may be off (relative)");
  v.value("gyro_axes_sigma_rad", o.calibration.gyro_axes_rad, {1e-7, 0.5},
          "how far the gyro's axes may be off the accelerometer's");
  v.value("acc_gain_sigma", o.calibration.acc_gain, {1e-7, 0.5},
          "how far the accelerometer's gain may be off (relative)");
  v.value("rest_sigma_v_mps", o.rest_sigma_v_mps, {1e-6, 10.0}, "velocity noise at standstill");
  v.value("rest_sigma_p_m", o.rest_sigma_p_m, {1e-6, 10.0}, "position noise at standstill");
  v.value("rest_sigma_theta_rad", o.rest_sigma_theta_rad, {1e-7, 1.0},
          "rotation noise at standstill");
}

void WindowOptions::validate() const {
  checkBounds(*this);
  if (newest_frames > keyframes) {
    refuseSetting("Window", "newest_frames", std::to_string(newest_frames),
                  "more frames than the window holds; allowed: at most keyframes = " +
                      std::to_string(keyframes));
  }
}

void describe(OptionVisitor& v, LongWindowOptions& o) {
  v.section("LongWindow", "The long window: how keyframes are tied together and to the anchors");
  v.value("conditional_edges", o.conditional_edges,
          "edges weighted by their covariance; false: by edge_sigma_*");
  v.value("heading", o.heading, "ranges may turn the heading, not only shift the position");
  v.value("gauge_free_prior", o.gauge_free_prior,
          "false: the odometry's claim to absolute position and yaw resists the ranges");
  v.value("ranges_at_own_time", o.ranges_at_own_time,
          "false: a range acts at its keyframe's position, whatever its own time");
  v.value("noise_from_residuals", o.noise_from_residuals,
          "the odometry is as uncertain as its sights fit well or badly, not as sigma_px says");
  v.value("edge_noise_scale", o.edge_noise_scale, {0.01, 100.0},
          "factor on the standard deviation of the odometry between keyframes");
  v.value("edge_sigma_m", o.edge_sigma_m, {1e-6, 10.0}, "position noise of an edge, if not known");
  v.value("edge_sigma_rad", o.edge_sigma_rad, {1e-7, 1.0}, "yaw noise of an edge, if not known");
  v.value("gamma_r", o.gamma_r, {1e-3, 1e3}, "weight of ranges (paper)");
  v.value("gamma_s", o.gamma_s, {1e-3, 1e6},
          "weight of the relative measurements in long_window = position (paper) [1/m]");
  v.value("scale_sigma", o.scale_sigma, {0.0, 1.0},
          "how far the odometry's scale may be off (log); 0 = it is right");
  v.value("scale_walk_per_sqrt_m", o.scale_walk_per_sqrt_m, {0.0, 1.0},
          "how much the scale wanders along the way");
  v.value("huber_delta", o.robust.huber_delta, {0.0, 1e6},
          "ranges shorter than expected by more weigh less [sigma]; 0 = never");
  v.value("nlos_delta", o.robust.nlos_delta, {0.0, 1e6},
          "ranges longer than expected by more weigh far less [sigma]; 0 = never");
}

void describeCalibrate(OptionVisitor& v, WindowOptions& o) {
  std::string calibrate = o.calibrate ? "online" : "trust";
  v.choice("calibrate", calibrate, {"online", "trust"},
           "online: time offset, camera pose and intrinsics are refined from what is given; trust: "
           "what is given is exact");
  o.calibrate = calibrate == "online";
}

void describeMode(OptionVisitor& v, LongWindowOptions& o) {
  chooseEnum(v, "long_window", o.mode, {"none", "position", "pose"},
             "pose: keyframes with heading, conditional edges; position: as in the paper; none: "
             "keyframes that leave the short window are folded into a prior");
  v.value("long_window_size", o.size, {1, 100000}, "keyframes in the long window");
  std::string anchor = o.anchor_fixed_after_init ? "fixed_after_init" : "estimate";
  v.choice("anchor", anchor, {"estimate", "fixed_after_init"},
           "estimate: anchors stay part of the state; fixed_after_init: as in the paper");
  o.anchor_fixed_after_init = anchor == "fixed_after_init";
}

void LongWindowOptions::validate() const {
  checkBounds(*this);
  OptionCheck check;
  check.section("Estimator", "");
  LongWindowOptions copy = *this;
  describeMode(check, copy);
}

}  // namespace vir::window
