/// print_poses RAWLOG [INI]: camera, IMU and ranges of a recording to poses, printed as
/// t x y z qx qy qz qw [s, m], one per image. INI: settings, e.g. the IMU's noise densities.
#include <mrpt/obs/CObservationImage.h>

#include <cstdio>
#include <exception>

#include "camera_of.h"
#include "vir/core/settings.h"
#include "vir/estimator/visual_inertial_estimator.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir/rawlog/time_orderer.h"

namespace {

using Vio = vir::estimator::VisualInertialEstimator;

void print(Vio& vio) {
  for (const vir::StateEstimate& e : vio.take()) {
    if (!e.valid) continue;
    const vir::Pose& T_W_B = e.state.T_W_B;
    std::printf("%.9f %.6f %.6f %.6f %.6f %.6f %.6f %.6f\n", vir::toSeconds(e.t_image), T_W_B.p.x(),
                T_W_B.p.y(), T_W_B.p.z(), T_W_B.q.x(), T_W_B.q.y(), T_W_B.q.z(), T_W_B.q.w());
  }
}

void add(const mrpt::obs::CObservation& observation, Vio& vio) {
  if (const auto imu = vir::rawlog::imuSampleOf(observation)) vio.addImu(*imu);
  if (observation.sensorLabel == vir::rawlog::kRangeLabel) {
    for (const vir::Range& range : vir::rawlog::rangesOf(observation)) vio.addRange(range);
  }
  if (const auto* image = dynamic_cast<const mrpt::obs::CObservationImage*>(&observation)) {
    if (!vio.hasCamera()) vio.setCamera(calibrationOf(*image), T_B_COf(*image));
    vio.addImage(vir::rawlog::fromMrptTime(image->timestamp), image->image.asCvMatRef());
  }
}

void run(const char* recording, const char* ini) {
  vir::estimator::EstimatorConfig config;
  if (ini != nullptr) {
    const vir::Settings settings = vir::Settings::fromFile(ini);
    vir::SettingsReader reader(settings);
    vir::estimator::describe(reader, config);
    reader.finish();
  }
  Vio vio(config);
  vir::rawlog::RawlogReader rawlog(recording);
  vir::rawlog::TimeOrderer in_order;  // a recorder writes each sensor in bursts
  while (const auto observation = rawlog.next()) {
    in_order.push(observation);
    while (const auto next = in_order.pop()) add(*next, vio);
    print(vio);
  }
  in_order.flush();
  while (const auto next = in_order.pop()) add(*next, vio);
  vio.finish();
  print(vio);
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
