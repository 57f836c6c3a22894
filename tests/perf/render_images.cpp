/// Flies a simulated camera through a made-up place: how many images per second, and some to look
/// at. render_images FLIGHT room|corridors [EXPOSURE_S [PREFIX]] writes PREFIX_<number>.png.
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "vir/rendering/camera_simulator.h"
#include "vir/rendering/make_scene.h"
#include "vir/simulation/flights.h"

using namespace vir;

namespace {

constexpr int kWrittenEvery = 8;

/// EuRoC's left camera, looking along the body's x axis.
CameraCalibration calibration() {
  CameraCalibration c;
  c.width = 752;
  c.height = 480;
  c.fx = 458.654;
  c.fy = 457.296;
  c.cx = 367.215;
  c.cy = 248.375;
  c.distortion = Distortion::radtan;
  c.dist = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0};
  return c;
}

void write(const std::string& prefix, int number, const rendering::GrayImage& image) {
  cv::Mat pixels(image.height, image.width, CV_8UC1,
                 const_cast<std::uint8_t*>(image.pixels.data()));
  char name[32];
  std::snprintf(name, sizeof name, "_%03d.png", number);
  cv::imwrite(prefix + name, pixels);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "render_images FLIGHT room|corridors [EXPOSURE_S [PREFIX]]\n");
    return 2;
  }
  try {
    const simulation::Motion motion = simulation::flight(argv[1], {});
    std::vector<Vec3> path;
    for (const StampedPose& s : motion.sampled(4)) path.push_back(s.T_W_B.p);
    rendering::SceneOptions scene_options;
    scene_options.layout = argv[2];
    const auto scene =
        std::make_shared<rendering::Scene>(rendering::makeScene(scene_options, path, {}));
    rendering::CameraSimulationOptions options;
    if (argc > 3) options.exposure_s = std::atof(argv[3]);
    rendering::CameraSimulator camera(options, scene, camera::makeCamera(calibration()));
    Mat3 R;
    R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    const Pose T_B_C(Quat(R), Vec3(0.05, 0.02, -0.01));
    int images = 0;
    double cpu = 0;
    for (double s = 1; s < motion.duration() - 1; s += 1.0, ++images) {
      const std::clock_t begin = std::clock();
      const rendering::GrayImage& image = camera.take(
          s, static_cast<std::uint64_t>(images),
          [&](double dt) { return motion.poseAt(motion.begin() + fromSeconds(s + dt)) * T_B_C; });
      cpu += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
      if (argc > 4 && images % kWrittenEvery == 0) write(argv[4], images, image);
    }
    std::printf("%zu boxes, %d images of 752x480: %.1f ms each, %.1f per second and core\n",
                scene->boxes().size(), images, 1000 * cpu / images, images / cpu);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "render_images: %s\n", e.what());
    return 2;
  }
  return 0;
}
