#include "commands/auto_driver.h"

#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include "vir/rawlog/rawlog_reader.h"
#include "vir/roles/estimator_registry.h"

namespace vir::app {
namespace {

using namespace mrpt::obs;

constexpr const char* kInertial = "vir";
constexpr const char* kOdometry = "odometry";
constexpr const char* kOdometryLabel = "ODOM";

}  // namespace

std::string driverFor(const std::string& driver, const std::string& rawlog) {
  if (driver != kAutoDriver) return driver;
  bool seen = false, imu = false, odometry = false;
  rawlog::RawlogReader reader(rawlog);
  while (const auto o = reader.next()) {
    seen = seen || dynamic_cast<const CObservationImage*>(o.get()) != nullptr ||
           dynamic_cast<const CObservationStereoImagesFeatures*>(o.get()) != nullptr;
    imu = imu || dynamic_cast<const CObservationIMU*>(o.get()) != nullptr;
    odometry = odometry || (o->sensorLabel == kOdometryLabel &&
                            dynamic_cast<const CObservationRobotPose*>(o.get()) != nullptr);
    if (seen && imu) return kInertial;
  }
  return odometry ? kOdometry : kInertial;
}

void acceptOtherDrivers(const std::string& asked, const std::string& chosen,
                        SettingsReader* reader) {
  if (asked != kAutoDriver) return;
  for (const roles::EstimatorEntry& e : roles::registeredEstimators()) {
    if ((e.name == kInertial || e.name == kOdometry) && e.name != chosen) {
      roles::createEstimator(e.name)->describe(*reader);
    }
  }
}

}  // namespace vir::app
