#pragma once
/// A small simulated world for the estimator's tests: an analytic motion, seeded random points in a
/// room, a pinhole camera looking ahead and an IMU. Everything is a function of the seed only. Not
/// the simulator of the program: this one renders no images.
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <vector>

#include "vir/geometry/pose.h"
#include "vir/imu/imu_buffer.h"
#include "vir/vision/feature_tracker.h"
#include "vir/window/short_window.h"

namespace vir_test {

using vir::ImuSample;
using vir::Mat3;
using vir::Pose;
using vir::TimeNs;
using vir::Vec2;
using vir::Vec3;

using Motion = std::function<Pose(double)>;  ///< T_W_B at a time [s]

/// Round and round a room at walking speed with sway in all axes.
inline Pose circling(double t) {
  const double w = 0.5, r = 2.5;
  const Vec3 p(r * std::cos(w * t) + 0.15 * std::sin(2.3 * t),
               r * std::sin(w * t) + 0.15 * std::sin(2.9 * t + 1), 0.3 * std::sin(1.7 * t));
  const double yaw = w * t + M_PI / 2 + 0.2 * std::sin(1.1 * t);
  const vir::Quat q = vir::Quat(vir::rotZ(yaw)) *
                      vir::expQuat(Vec3(0, 0.1 * std::sin(1.9 * t), 0)) *
                      vir::expQuat(Vec3(0.15 * std::sin(1.3 * t + 0.5), 0, 0));
  return {q, p};
}

inline Pose still(double) {
  return {vir::expQuat(Vec3(0, 0.1, 0)) * vir::expQuat(Vec3(0.05, 0, 0)), Vec3(0.5, 0, 0)};
}

/// The way of `circling`, with the quick turns of a drone that is flown by hand.
inline Pose flying(double t) {
  const Pose slow = circling(t);
  return {slow.q * vir::expQuat(Vec3(0.16 * std::sin(4.1 * t + 1), 0.14 * std::sin(5.3 * t),
                                     0.18 * std::sin(3.4 * t + 2))),
          slow.p};
}

/// The attitude of `circling`, at one place (the camera turns about its own centre).
inline Pose turningOnTheSpot(double t) { return {circling(t).q, Vec3::Zero()}; }

class Scene {
 public:
  static constexpr double kFocal = 400, kWidth = 640, kHeight = 480, kGravity = 9.81;

  explicit Scene(Motion motion, unsigned seed = 1, int points = 500)
      : motion_(std::move(motion)), random_(seed) {
    std::uniform_real_distribution<double> u(-1, 1);
    for (int k = 0; k < points; ++k) {
      const double a = 6 * u(random_), b = 6 * u(random_), h = 3 * u(random_);
      const Vec3 sides[4] = {Vec3(6, a, h), Vec3(-6, a, h), Vec3(a, 6, h), Vec3(a, -6, h)};
      const Vec3 wall = sides[k / 2 % 4] + 0.5 * Vec3(b / 6, u(random_), 0);
      // Every second point stands somewhere in the room: a bare wall alone hardly tells a turn from
      // a sideways step.
      points_.push_back(k % 2 ? Vec3(0.9 * a, 0.9 * b, h) : wall);
    }
  }

  /// The camera looks along body x, its image's right is body -y; 5 cm ahead and a little tilted.
  static Pose T_B_C() {
    Mat3 R;
    R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    return {vir::Quat(R) * vir::expQuat(Vec3(0.02, -0.03, 0.01)), Vec3(0.05, 0.02, -0.01)};
  }

  static vir::Calibration calibration() {
    vir::Calibration c;
    c.camera.width = static_cast<int>(kWidth);
    c.camera.height = static_cast<int>(kHeight);
    c.camera.fx = c.camera.fy = kFocal;
    c.camera.cx = kWidth / 2;
    c.camera.cy = kHeight / 2;
    c.T_B_C = T_B_C();
    return c;
  }

  Vec3 bias_gyro = Vec3::Zero(), bias_acc = Vec3::Zero();
  double noise_px = 0, noise_gyro = 0, noise_acc = 0;  ///< of pixels; densities
  std::size_t max_tracks = 60;

  vir::State truth(TimeNs t) const {
    const double s = vir::toSeconds(t);
    vir::State out;
    out.t = t;
    out.T_W_B = motion_(s);
    out.v = (8 * (p(s + kH) - p(s - kH)) - (p(s + 2 * kH) - p(s - 2 * kH))) / (12 * kH);
    out.bg = bias_gyro;
    out.ba = bias_acc;
    return out;
  }

  /// The reading at t, `rate_hz` being the rate that the noise density is turned into noise with.
  ImuSample imu(TimeNs t, double rate_hz = 200) {
    const double s = vir::toSeconds(t);
    const Vec3 a = (16 * (p(s + kH) + p(s - kH)) - (p(s + 2 * kH) + p(s - 2 * kH)) - 30 * p(s)) /
                   (12 * kH * kH);
    const auto turn = [&](double h) {
      return vir::logQuat(motion_(s - h).q.conjugate() * motion_(s + h).q);
    };
    const Vec3 w = (8 * turn(kH) - turn(2 * kH)) / (12 * kH);
    const double root = std::sqrt(rate_hz);
    return {t, w + bias_gyro + normal3(noise_gyro * root),
            motion_(s).q.conjugate() * (a + Vec3(0, 0, kGravity)) + bias_acc +
                normal3(noise_acc * root)};
  }

  /// What a perfect tracker sees: tracks live while the point stays in view; who comes back gets a
  /// new number. Rates are those from the image before. Ordered by id.
  std::vector<vir::vision::FeatureObservation> observe(TimeNs t) {
    const Pose T_C_W = (motion_(vir::toSeconds(t)) * T_B_C()).inverse();
    std::map<int, std::uint64_t> seen;
    std::map<std::uint64_t, vir::vision::FeatureObservation> out;
    const auto take = [&](int k, bool fresh) {
      const Vec3 p_C = T_C_W * points_[static_cast<std::size_t>(k)];
      if (p_C.z() < 0.3) return;
      const Vec2 px = kFocal * p_C.head<2>() / p_C.z() + Vec2(kWidth, kHeight) / 2;
      if (px.x() < 5 || px.y() < 5 || px.x() > kWidth - 5 || px.y() > kHeight - 5) return;
      const std::uint64_t id = fresh ? next_id_++ : live_.at(k);
      seen[k] = id;
      point_of_[id] = k;
      out[id] = observation(id, px + noise_px * Vec2(normal_(random_), normal_(random_)));
    };
    for (const auto& [k, id] : std::map<int, std::uint64_t>(live_)) take(k, false);
    for (int k = 0; k < static_cast<int>(points_.size()); ++k) {
      if (out.size() >= max_tracks) break;
      if (!live_.count(k)) take(k, true);
    }
    live_ = seen;
    std::vector<vir::vision::FeatureObservation> list;
    std::map<std::uint64_t, Vec3> bearings;
    for (auto& [id, o] : out) {
      const auto before = last_bearing_.find(id);
      if (before != last_bearing_.end() && t > last_image_) {
        o.bearing_rate = (o.bearing - before->second) / vir::toSeconds(t - last_image_);
      }
      bearings[id] = o.bearing;
      list.push_back(o);
    }
    last_bearing_ = std::move(bearings);
    last_image_ = t;
    return list;
  }

  /// As a tracker with a pinhole camera reports a pixel.
  static vir::vision::FeatureObservation observation(std::uint64_t id, const Vec2& px) {
    vir::vision::FeatureObservation o;
    o.id = id;
    o.px = px;
    o.bearing << (px - Vec2(kWidth, kHeight) / 2) / kFocal, 1;
    o.bearing.normalize();
    const Vec3& b = o.bearing;
    o.dpx_dbearing << kFocal / b.z(), 0, -kFocal * b.x() / (b.z() * b.z()), 0, kFocal / b.z(),
        -kFocal * b.y() / (b.z() * b.z());
    return o;
  }

  const Vec3& point(std::uint64_t id) const {
    return points_[static_cast<std::size_t>(point_of_.at(id))];
  }

  /// Seeded normal numbers, also for the tests' own perturbations.
  Vec3 normal3(double sigma) {
    const double x = normal_(random_), y = normal_(random_), z = normal_(random_);
    return sigma * Vec3(x, y, z);
  }

 private:
  static constexpr double kH = 2e-3;  // of the fourth-order differences [s]
  Vec3 p(double s) const { return motion_(s).p; }

  Motion motion_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  std::vector<Vec3> points_;
  std::map<int, std::uint64_t> live_;
  std::map<std::uint64_t, int> point_of_;
  std::map<std::uint64_t, Vec3> last_bearing_;
  TimeNs last_image_ = 0;
  std::uint64_t next_id_ = 1;
};

}  // namespace vir_test
