#pragma once
/// Sensor "pyfg": one robot of a PyFG factor graph as MRPT observations.
#include <mrpt/hwdrivers/CGenericSensor.h>
#include <mrpt/obs/obs_frwds.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "pyfg_options.h"
#include "robot_recording.h"
#include "vir/roles/recorded_source.h"

namespace vir {

/// Gives in time order, as fast as doProcess() is called:
/// - `GT`: the true poses;
/// - `ODOM`: the measured motions put together from identity on. `pose.cov` is the covariance of
///   the motion since the ODOM before (not of the pose in its world, which grows without end):
///   position along the axes of the odometry's world [m^2], rotation on the right [rad^2]; zero
///   means not known, kUnknown*Variance that the motion is missing;
/// - `UWB0`: one range each to a landmark; beaconID is the landmark's number, the antenna is at the
///   body's origin;
/// - `PEER`: one range each to another robot; beaconID is robotId() of its letter, whichever of the
///   two the file names first.
/// The label set for the sensor is not used.
class PyfgDataset : public mrpt::hwdrivers::CGenericSensor, public roles::RecordedSource {
  DEFINE_GENERIC_SENSOR(PyfgDataset)
 public:
  PyfgDataset();
  ~PyfgDataset() override;

  // CGenericSensor
  void initialize() override;
  void doProcess() override;

  // RecordedSource
  void describe(OptionVisitor& v) override;
  double progress() const override;
  bool finished() const override;
  std::vector<std::pair<std::string, long>> counters() const override;
  std::vector<std::string> warnings() const override;
  std::vector<roles::TrueAnchor> trueAnchors() const override;
  bool canRead(const std::string& source) const override;

 protected:
  void loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                 const std::string& section) override;

 private:
  pyfg::PyfgOptions options_;
  ProblemLog log_;
  pyfg::RobotRecording recording_;
  std::size_t at_ = 0;  ///< next event
  bool initialized_ = false;
  std::map<std::string, long> given_;  ///< observations handed out, by counter name
};

}  // namespace vir
