/// The IMU alone, integrated from a start at rest: a pose per image that soon drifts away. Shows
/// what an estimator has to do, not how to do it well.
#include <stdexcept>

#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/roles/estimator_registry.h"

namespace example {

using vir::TimeNs;
using vir::Vec3;

struct Options {
  double rest_s = 1;
  double gravity_mps2 = 9.81;
};

class Inertial : public vir::roles::Estimator {
 public:
  Inertial(const Options& options, vir::LogSink log) : options_(options), log_(std::move(log)) {}

  void add(const mrpt::obs::CObservation& observation) override {
    if (const auto imu = vir::rawlog::imuSampleOf(observation)) addImu(*imu);
    if (!vir::rawlog::isImage(observation)) return;
    vir::StateEstimate estimate = estimate_;
    estimate.t_image = estimate.state.t = vir::rawlog::fromMrptTime(observation.timestamp);
    if (!estimate.valid) estimate.reason = "waiting for the end of the rest";
    new_.states.push_back(estimate);
  }
  void finish() override {}
  vir::roles::EstimatorOutput take() override { return std::exchange(new_, {}); }
  std::vector<vir::Landmark> landmarks() const override { return {}; }
  std::vector<vir::StampedPose> keyframes() const override { return {}; }
  vir::roles::EstimatorReport report() const override {
    vir::roles::EstimatorReport report;
    report.counters = {{"imu_readings", readings_}};
    return report;
  }

 private:
  void addImu(const vir::ImuSample& imu) {
    if (readings_++ == 0) first_t_ = last_t_ = imu.t;
    const double dt = vir::toSeconds(imu.t - last_t_);
    last_t_ = imu.t;
    if (vir::toSeconds(imu.t - first_t_) < options_.rest_s) {
      sum_gyro_ += imu.gyro;
      sum_acc_ += imu.acc;
      ++rest_readings_;
      return;
    }
    vir::State& s = estimate_.state;
    if (!estimate_.valid) {
      if (rest_readings_ == 0) throw std::runtime_error("there are no IMU readings at rest");
      s.bg = sum_gyro_ / static_cast<double>(rest_readings_);
      s.T_W_B.q = vir::gravityAlignedAttitude(sum_acc_);
      estimate_.valid = true;
      estimate_.health = vir::Health::ok;
      vir::log(log_, vir::LogLevel::info, "the rest is over: integrating");
    }
    s.T_W_B.q = (s.T_W_B.q * vir::expQuat((imu.gyro - s.bg) * dt)).normalized();
    const Vec3 a_W = s.T_W_B.q * imu.acc - Vec3(0, 0, options_.gravity_mps2);
    s.T_W_B.p += s.v * dt + a_W * (dt * dt / 2);
    s.v += a_W * dt;
  }

  Options options_;
  vir::LogSink log_;
  vir::StateEstimate estimate_;
  vir::roles::EstimatorOutput new_;
  TimeNs first_t_ = 0, last_t_ = 0;
  long readings_ = 0, rest_readings_ = 0;
  Vec3 sum_gyro_ = Vec3::Zero(), sum_acc_ = Vec3::Zero();
};

class InertialSettings : public vir::roles::EstimatorSettings {
 public:
  void describe(vir::OptionVisitor& v) override {
    v.section("Estimator", "IMU alone, from a start at rest");
    v.value("rest_s", options_.rest_s, {0.01, 60}, "how long the body rests at the start");
    v.value("gravity_mps2", options_.gravity_mps2, {9, 10}, "gravity of the place");
  }
  std::vector<vir::roles::EstimatorInput> inputs() const override {
    using vir::roles::InputKind;
    return {{InputKind::imu, vir::rawlog::kImuLabel, 1},
            {InputKind::image, vir::rawlog::kCameraLabel, 2}};
  }
  double gravity() const override { return options_.gravity_mps2; }
  std::unique_ptr<vir::roles::Estimator> create(const vir::LogSink& log,
                                                std::function<void()>) const override {
    return std::make_unique<Inertial>(options_, log);
  }

 private:
  Options options_;
};

VIR_REGISTER_ESTIMATOR(InertialSettings, "inertial", "IMU alone, from a start at rest (example)");

}  // namespace example
