/// print_poses RAWLOG [INI]: camera, IMU and ranges of a recording to poses, printed as
/// t x y z qx qy qz qw [s, m], one per image. INI: settings, e.g. the IMU's noise densities.
#include <iostream>

#include "vir/estimator/vio.h"
#include "vir/evaluation/trajectory.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/gray_image.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/ordered_reader.h"

namespace {

void printPoses(const char* recording, const vir::estimator::EstimatorConfig& config) {
  vir::Vio vio(vir::rawlog::calibrationIn(recording, vir::rawlog::kCameraLabel), config);
  vio.onState([](const vir::StateEstimate& e) {
    if (e.valid) std::cout << vir::evaluation::tumLine({e.state.t, e.state.T_W_B}) << "\n";
  });
  vir::rawlog::OrderedReader observations(recording);
  while (const auto o = observations.next()) {
    if (const auto imu = vir::rawlog::imuSampleOf(*o)) vio.add(*imu);
    if (const auto image = vir::rawlog::grayImageOf(*o)) vio.add(image->view());
    if (o->sensorLabel != vir::rawlog::kRangeLabel) continue;
    for (const vir::Range& range : vir::rawlog::rangesOf(*o)) vio.add(range);
  }
  vio.finish();
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2 && argc != 3) throw std::invalid_argument("usage: print_poses RAWLOG [INI]");
  printPoses(argv[1], argc == 3 ? vir::estimator::configFromFile(argv[2])
                                : vir::estimator::EstimatorConfig());
  return 0;
} catch (const std::exception& e) {
  std::cerr << "print_poses: " << e.what() << "\n";
  return 1;
}
