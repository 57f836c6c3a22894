#pragma once
/// An estimator fed with a flight that bytes disturb: readings, tracks and ranges in any order,
/// with any stamp and any number.
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "vir/camera/camera_model.h"
#include "vir/core/time_bounds.h"
#include "vir/estimator/visual_inertial_estimator.h"
#include "vir_test_extremes.h"

namespace vir::test {

class RandomInput {
 public:
  RandomInput(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {
    CameraCalibration c;
    c.width = 320;
    c.height = 240;
    c.fx = c.fy = 250;
    c.cx = 160;
    c.cy = 120;
    camera_ = camera::makeCamera(c);
    estimator_.setCamera(c, T_B_C_);
  }

  /// Empty, or what is wrong with what came out.
  std::string run() {
    for (int steps = 0; at_ < size_ && steps < kMostSteps; ++steps) {
      const std::uint8_t what = byte();
      if (what < kGoOn) {
        advance(true, true);
      } else {
        disturb(what % 16);
      }
    }
    estimator_.finish();
    return problem();
  }

  long poses() const { return poses_; }

 private:
  static constexpr int kMostSteps = 150;
  static constexpr std::uint8_t kGoOn = 200;
  static constexpr TimeNs kImage = 50'000'000, kReading = 5'000'000;
  static constexpr TimeNs kStart = 1'700'000'000'000'000'000;

  std::uint8_t byte() { return at_ < size_ ? data_[at_++] : 0; }
  double number() {
    const std::uint8_t b = byte();
    return b < 2 * extremes().size() ? extremes()[b % extremes().size()] : (b - 128) * 0.5;
  }
  Vec3 vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }
  /// About now, or anywhere.
  TimeNs stamp() {
    const std::uint8_t b = byte();
    if (b == 0) return INT64_MIN;
    if (b == 1) return INT64_MAX;
    if (b == 2) return -1;
    if (b < 10) return TimeNs(1) << (50 + b);
    return now_ + TimeNs{b - 128} * 20'000'000;
  }

  /// The flight, by its own equations.
  static Vec3 position(double s) {
    return {std::sin(s), 0.7 * std::cos(1.3 * s), 0.3 * std::sin(0.8 * s)};
  }
  static Vec3 acceleration(double s) {
    return {-std::sin(s), -0.7 * 1.69 * std::cos(1.3 * s), -0.3 * 0.64 * std::sin(0.8 * s)};
  }
  static Quat attitude(double s) {
    return Quat(Eigen::AngleAxisd(0.3 * std::sin(0.9 * s), Vec3::UnitZ()));
  }

  ImuSample reading(TimeNs t) const {
    const double s = toSeconds(timeBetween(kStart, t));
    return {t, Vec3(0, 0, 0.27 * std::cos(0.9 * s)),
            attitude(s).conjugate() * (acceleration(s) + Vec3(0, 0, 9.81))};
  }

  vision::TrackedFrame tracks(TimeNs t) const {
    const double s = toSeconds(timeBetween(kStart, t));
    const Pose T_C_W = (Pose(attitude(s), position(s)) * T_B_C_).inverse();
    vision::TrackedFrame frame;
    frame.t = t;
    for (std::uint64_t id = 0; id < 40; ++id) {
      const double k = static_cast<double>(id);
      const Vec3 p_W(6 + std::fmod(k * 1.7, 3.0), std::fmod(k * 0.77, 5.0) - 2.5,
                     std::fmod(k * 1.3, 4.0) - 2);
      vision::FeatureObservation f;
      f.id = id;
      f.age = static_cast<int>(timeBetween(kStart, t) / kImage);
      const Vec3 p_C = T_C_W * p_W;
      if (!camera_->project(p_C, &f.px)) continue;
      f.bearing = p_C.normalized();
      Vec2 ignored;
      camera_->project(f.bearing, &ignored, &f.dpx_dbearing);
      frame.features.push_back(f);
    }
    frame.continued = static_cast<int>(frame.features.size());
    frame.median_flow_px = frame.median_parallax_px = 3;
    frame.mean_intensity = 100;
    return frame;
  }

  void advance(bool with_readings, bool with_image) {
    for (TimeNs t = now_ + kReading; with_readings && t <= now_ + kImage; t += kReading) {
      estimator_.addImu(reading(t));
    }
    now_ += kImage;
    if (with_image) estimator_.addTracks(tracks(now_));
    range(now_ - 7'000'000, (position(toSeconds(now_ - kStart)) - Vec3(3, 2, 1)).norm());
  }

  void range(TimeNs t, double metres) {
    Range r;
    r.t = t;
    r.anchor = 4;
    r.range_m = metres;
    estimator_.addRange(r);
  }

  void disturb(int how) {
    switch (how) {
      case 0:
        return estimator_.addImu({stamp(), vector(), vector()});
      case 1: {
        ImuSample s = reading(now_ + kReading);
        (byte() % 2 == 0 ? s.gyro : s.acc) = vector();
        return estimator_.addImu(s);
      }
      case 2:
        return estimator_.addTracks(tracks(stamp()));
      case 3: {
        vision::TrackedFrame frame = tracks(now_ + kImage / 2);
        for (vision::FeatureObservation& f : frame.features) spoil(&f);
        return estimator_.addTracks(frame);
      }
      case 4:
        return estimator_.addImage(now_ + kImage / 2, cv::Mat());
      case 5:
        return range(stamp(), number());
      case 6: {
        Range r;
        r.t = now_;
        r.anchor = byte() < 128 ? byte() : UINT64_MAX;
        r.range_m = number();
        r.sigma_m = number();
        r.p_B_U = vector();
        return estimator_.addRange(r);
      }
      case 7:
        return estimator_.anchorDeployed(byte() % 8, vector(), number());
      case 8:  // readings are missing
        return advance(false, true);
      case 9:
        return advance(true, false);
      case 10: {  // the image before its readings
        estimator_.addTracks(tracks(now_ + kImage));
        return advance(true, false);
      }
      case 11:  // the clock is set
        now_ += (byte() - 128) * TimeNs(100'000'000);
        return;
      case 12: {  // readings backwards
        for (TimeNs t = now_ + kImage; t > now_; t -= kReading) estimator_.addImu(reading(t));
        return;
      }
      case 13: {
        const std::uint8_t many = byte();
        for (int i = 0; i < many % 64; ++i) estimator_.addImu({now_ - i, vector(), vector()});
        return;
      }
      case 14: {
        vision::TrackedFrame frame = tracks(now_ + kImage / 2);
        frame.features.resize(std::min<std::size_t>(frame.features.size(), byte() % 8));
        return estimator_.addTracks(frame);
      }
      default:
        for (const StateEstimate& e : estimator_.take()) look(e);
    }
  }

  void spoil(vision::FeatureObservation* f) {
    switch (byte() % 4) {
      case 0:
        f->px = vector().head<2>();
        break;
      case 1:
        f->bearing = vector();
        break;
      case 2:
        f->bearing_rate = vector();
        break;
      default:
        f->dpx_dbearing.row(0) = vector();
    }
  }

  void look(const StateEstimate& e) {
    if (!e.valid) return;
    ++poses_;
    const State& s = e.state;
    if (!s.T_W_B.p.allFinite() || !s.T_W_B.q.coeffs().allFinite() || !s.v.allFinite() ||
        !s.bg.allFinite() || !s.ba.allFinite()) {
      problem_ = "a state that is valid is no number";
    }
  }

  std::string problem() {
    for (const StateEstimate& e : estimator_.take()) look(e);
    for (const State& s : estimator_.keyframes()) {
      if (!s.T_W_B.p.allFinite()) problem_ = "a keyframe is no number";
    }
    for (const Landmark& l : estimator_.landmarks()) {
      if (!l.p_W.allFinite()) problem_ = "a landmark is no number";
    }
    for (const Anchor& a : estimator_.anchors()) {
      if (a.has_position && !a.p_W.allFinite()) problem_ = "an anchor is no number";
    }
    return problem_;
  }

  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
  // The camera looks along x of the body.
  const Pose T_B_C_{Quat(0.5, -0.5, 0.5, -0.5), Vec3(0.05, 0, 0)};
  std::shared_ptr<const camera::CameraModel> camera_;
  estimator::VisualInertialEstimator estimator_{estimator::EstimatorConfig()};
  TimeNs now_ = kStart;
  std::string problem_;
  long poses_ = 0;
};

}  // namespace vir::test
