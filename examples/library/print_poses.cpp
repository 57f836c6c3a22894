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

void printPoses(const char* recording, const vir::estimator::VioConfig& config) {
  using namespace vir::rawlog;
  vir::Vio vio(calibrationIn(recording, kCameraLabel), config);
  vio.onState([](const vir::StateEstimate& e) {
    if (e.valid) std::cout << vir::evaluation::tumLine({e.state.t, e.state.T_W_B}) << "\n";
  });
  OrderedReader observations(recording);
  while (const auto o = observations.next()) {
    if (o->sensorLabel == kImuLabel) vio.add(imuSampleOf(*o).value());
    if (o->sensorLabel == kCameraLabel) vio.add(grayImageOf(*o).value().view());
    if (o->sensorLabel != kRangeLabel) continue;
    for (const vir::Range& range : rangesOf(*o)) vio.add(range);
  }
  vio.finish();
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2 && argc != 3) throw std::invalid_argument("usage: print_poses RAWLOG [INI]");
  printPoses(argv[1], argc == 3 ? vir::estimator::configFrom(vir::Settings::fromFile(argv[2]))
                                : vir::estimator::VioConfig());
  return 0;
} catch (const std::exception& e) {
  std::cerr << "print_poses: " << e.what() << "\n";
  return 1;
}
