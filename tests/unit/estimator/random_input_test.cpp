/// The whole estimator fed with random readings, images and ranges in random order: it does not
/// crash, does not stay, and no result is NaN.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "estimator_driver.h"
#include "vir/core/random.h"
#include "vir/estimator/vio.h"

namespace vir {
namespace {

using vir_test::kMs;

constexpr TimeNs kStart = 1400000000000000000;

struct Event {
  TimeNs due = 0;  ///< its place in the order
  enum { imu, image, range } kind = imu;
  TimeNs t = 0;  ///< its stamp
};

class RandomInput {
 public:
  explicit RandomInput(int seed) : random_(static_cast<std::uint64_t>(seed), 7) {
    calibration_.T_B_C.p = Vec3(0.01, 0, 0);
    calibration_.camera.width = vir_test::kWidth;
    calibration_.camera.height = vir_test::kHeight;
    calibration_.camera.fx = calibration_.camera.fy = 250;
    calibration_.camera.cx = vir_test::kWidth / 2.0;
    calibration_.camera.cy = vir_test::kHeight / 2.0;
    // From now and then to most of the time.
    wrong_ = 0.003 * std::pow(3.0, seed % 6);
  }

  /// Three seconds of standing, of which a share is wrong.
  void feed(Vio* vio) {
    std::vector<Event> events;
    for (int k = 0; k < 600; ++k) {
      const TimeNs t = kStart + 5 * k * kMs;
      events.push_back(event(Event::imu, t));
      if (k % 10 == 0) events.push_back(event(Event::image, t));
      if (k % 20 == 0) events.push_back(event(Event::range, t));
    }
    std::stable_sort(events.begin(), events.end(),
                     [](const Event& a, const Event& b) { return a.due < b.due; });
    for (const Event& e : events) give(e, vio);
    vio->finish();
  }
  const Calibration& calibration() const { return calibration_; }

 private:
  bool wrong() { return random_.uniform() < wrong_; }
  double extreme() {
    constexpr double inf = std::numeric_limits<double>::infinity();
    const double all[] = {0.0,
                          -1,
                          1e-300,
                          5e-324,
                          50,
                          1e3,
                          1e18,
                          1e30,
                          inf,
                          -inf,
                          -1e308,
                          1e308,
                          std::numeric_limits<double>::quiet_NaN()};
    return all[static_cast<std::size_t>(random_.uniform() * 0.999999 * std::size(all))];
  }
  double value(double good) { return wrong() ? extreme() : good + 0.01 * random_.normal(); }
  Vec3 vector(double x, double y, double z) { return {value(x), value(y), value(z)}; }

  Event event(decltype(Event::kind) kind, TimeNs t) {
    Event e{t, kind, t};
    if (wrong()) e.due += fromSeconds(random_.uniform(-1, 1));
    if (!wrong()) return e;
    const TimeNs all[] = {
        0,           -1,          1, INT64_MAX, INT64_MIN, t - 1000000 * kMs, t + 10000 * kMs,
        t + 7 * kMs, t - 20 * kMs};
    e.t = all[static_cast<std::size_t>(random_.uniform() * 0.999999 * std::size(all))];
    return e;
  }

  void give(const Event& e, Vio* vio) {
    switch (e.kind) {
      case Event::imu:
        vio->add(ImuSample{e.t, vector(0.01, 0, -0.02), vector(0, 0, 9.81)});
        return;
      case Event::range:
        vio->add(Range{e.t, static_cast<std::uint64_t>(3 + (wrong() ? 1000000 : 0)), value(2.5),
                       wrong() ? extreme() : 0.1, vector(0, 0, 0.1)});
        return;
      case Event::image:
        break;
    }
    cv::Mat image = texture_;
    if (wrong()) image = vir_test::texture(static_cast<unsigned>(e.due / kMs));
    if (wrong()) image = cv::Mat(vir_test::kHeight, vir_test::kWidth, CV_8UC1, cv::Scalar(0));
    vio->add(Image{e.t, image.cols, image.rows, image.data, image.step});
  }

  Random random_;
  double wrong_ = 0;
  Calibration calibration_;
  cv::Mat texture_ = vir_test::texture(1);
};

TEST(RandomInput, EveryResultIsFinite) {
  for (int seed = 0; seed < 18; ++seed) {
    SCOPED_TRACE(seed);
    RandomInput input(seed);
    const estimator::EstimatorConfig config;
    Vio vio(input.calibration(), config);
    long states = 0, valid = 0;
    vio.onState([&](const StateEstimate& s) {
      ++states;
      valid += s.valid ? 1 : 0;
      EXPECT_TRUE(vir_test::finite(s));
      EXPECT_TRUE(s.covariance.allFinite());
      EXPECT_TRUE(s.valid || !s.reason.empty());
    });
    input.feed(&vio);
    EXPECT_GT(states, 0);
    if (seed % 6 == 0) {
      EXPECT_GT(valid, 25) << "little was wrong";
    }
    for (const StampedPose& k : vio.keyframes()) {
      EXPECT_TRUE(k.T_W_B.p.allFinite() && k.T_W_B.q.coeffs().allFinite());
    }
    for (const Landmark& l : vio.landmarks()) EXPECT_TRUE(l.p_W.allFinite());
    for (const Anchor& a : vio.anchors()) {
      EXPECT_TRUE(!a.has_position || (a.p_W.allFinite() && a.covariance.allFinite()));
    }
    const Calibration c = vio.calibration();
    EXPECT_TRUE(std::isfinite(c.time_offset_s) && std::isfinite(c.camera.fx) &&
                c.T_B_C.p.allFinite());
  }
}

}  // namespace
}  // namespace vir
