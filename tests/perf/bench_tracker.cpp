/// CPU time of the tracker on rendered 752x480 views: all of it, and with nothing to detect.
#include <benchmark/benchmark.h>

#include <opencv2/core.hpp>

#include "synthetic_view.h"
#include "vir/vision/feature_tracker.h"

namespace {

using namespace vir;

struct Views {
  std::shared_ptr<const camera::CameraModel> camera;
  std::vector<cv::Mat> images;
  std::vector<Mat3> R_C0_C1;

  Views() {
    CameraCalibration c = test::smallCamera();
    c.width *= 2;
    c.height *= 2;
    c.fx = c.fy = 458.0;
    c.cx *= 2;
    c.cy *= 2;
    camera = camera::makeCamera(c);
    const test::SyntheticPlane plane(0.002);
    // Back and forth, so that the loop has no jump.
    for (int i = 0; i < 16; ++i) {
      const double u = i < 8 ? i : 16 - i;
      const Pose pose =
          test::lookingDown(Vec3(0.03 * u, 0.02 * u, 2.0), Vec3(0.1, 0.02 * u, 0.01 * u));
      poses.push_back(pose);
      images.push_back(plane.render(*camera, pose));
      const Pose& before = poses[i == 0 ? 0 : static_cast<std::size_t>(i - 1)];
      R_C0_C1.push_back((before.q.conjugate() * pose.q).toRotationMatrix());
    }
    R_C0_C1[0] = (poses.back().q.conjugate() * poses[0].q).toRotationMatrix();
  }
  std::vector<Pose> poses;
};

void trackImages(benchmark::State& state) {
  static const Views views;
  cv::setNumThreads(1);
  vision::TrackerOptions options;
  options.max_tracks = static_cast<int>(state.range(0));
  vision::FeatureTracker tracker(options, views.camera);
  std::size_t i = 0;
  double tracks = 0;
  for (auto _ : state) {
    const std::size_t k = i % views.images.size();
    const vision::TrackedFrame frame =
        tracker.process(static_cast<TimeNs>(i) * 50000000, views.images[k], views.R_C0_C1[k]);
    tracks += frame.continued;
    ++i;
  }
  state.counters["tracks"] = tracks / static_cast<double>(state.iterations());
}
BENCHMARK(trackImages)->Arg(50)->Arg(150)->Arg(300)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
