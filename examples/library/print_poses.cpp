/// print_poses RAWLOG [INI]: camera, IMU and ranges of a recording to poses, printed as
/// t x y z qx qy qz qw [s, m], one per image. INI: settings, e.g. the IMU's noise densities.
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>

#include "image_of.h"
#include "vir/core/settings.h"
#include "vir/estimator/vio.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir/rawlog/time_orderer.h"

namespace {

void print(const vir::StateEstimate& estimate) {
  if (!estimate.valid) return;
  const vir::StampedPose s{estimate.state.t, estimate.state.T_W_B};
  std::printf("%.9f %.6f %.6f %.6f %.6f %.6f %.6f %.6f\n", vir::toSeconds(s.t), s.T_W_B.p.x(),
              s.T_W_B.p.y(), s.T_W_B.p.z(), s.T_W_B.q.x(), s.T_W_B.q.y(), s.T_W_B.q.z(),
              s.T_W_B.q.w());
}

/// The camera comes with the images.
vir::Calibration calibrationIn(const char* recording) {
  vir::rawlog::RawlogReader rawlog(recording);
  while (const auto observation = rawlog.next()) {
    const auto* image = dynamic_cast<const mrpt::obs::CObservationImage*>(observation.get());
    if (image != nullptr) return calibrationOf(*image);
  }
  throw std::runtime_error(std::string("there is no image in ") + recording);
}

void add(const mrpt::obs::CObservation& observation, vir::Vio& vio) {
  if (const auto imu = vir::rawlog::imuSampleOf(observation)) vio.add(*imu);
  const auto* image = dynamic_cast<const mrpt::obs::CObservationImage*>(&observation);
  if (image != nullptr) vio.add(imageOf(*image));
  if (observation.sensorLabel != vir::rawlog::kRangeLabel) return;
  for (const vir::Range& range : vir::rawlog::rangesOf(observation)) vio.add(range);
}

void run(const char* recording, const char* ini) {
  vir::estimator::EstimatorConfig config;
  if (ini != nullptr) {
    const vir::Settings settings = vir::Settings::fromFile(ini);
    vir::SettingsReader reader(settings);
    vir::estimator::describe(reader, config);
    reader.finish();
  }
  vir::Vio vio(calibrationIn(recording), config);
  vio.onState(print);
  vir::rawlog::RawlogReader rawlog(recording);
  vir::rawlog::TimeOrderer in_order;  // a recorder writes each sensor in bursts
  while (const auto observation = rawlog.next()) {
    in_order.push(observation);
    while (const auto next = in_order.pop()) add(*next, vio);
  }
  in_order.flush();
  while (const auto next = in_order.pop()) add(*next, vio);
  vio.finish();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fprintf(stderr, "usage: print_poses RAWLOG [INI]\n");
    return 2;
  }
  try {
    run(argv[1], argc > 2 ? argv[2] : nullptr);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "print_poses: %s\n", e.what());
    return 1;
  }
  return 0;
}
