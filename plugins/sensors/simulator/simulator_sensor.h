#pragma once
/// Sensor "simulator": what one robot of a made-up world records, as MRPT observations.
#include <mrpt/hwdrivers/CGenericSensor.h>
#include <mrpt/obs/obs_frwds.h>

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "image_writer.h"
#include "simulator_options.h"
#include "vir/roles/recorded_source.h"
#include "world.h"

namespace vir {

/// Gives in time order, as fast as doProcess() is called: `IMU0`; `CAM0` or `TRACKS0`; `UWB0`, one
/// range each; with several robots `PEER` and at the same time `PEER:<id>` and
/// `PEER:<id>:ANCHOR:<a>` (positions the other robot tells, of its antenna and its anchors, in its
/// own world); `ODOM`; `GT`, all robots' in one world. The label set for the sensor is not used.
///
/// In an ini of rawlog-grabber: `ini` names the file with the settings, `robot` the robot.
class SimulatorSensor : public mrpt::hwdrivers::CGenericSensor, public roles::RecordedSource {
  DEFINE_GENERIC_SENSOR(SimulatorSensor)
 public:
  SimulatorSensor();
  ~SimulatorSensor() override;

  // CGenericSensor
  void initialize() override;
  void doProcess() override;
  /// Where external images go. Not called: images are embedded.
  void setPathForExternalImages(const std::string& directory) override;

  // RecordedSource
  void describe(OptionVisitor& v) override;
  double progress() const override;
  bool finished() const override;
  std::vector<std::pair<std::string, long>> counters() const override;
  std::vector<std::string> warnings() const override;
  std::string companionIni() const override;
  std::vector<roles::TrueAnchor> trueAnchors() const override;

 protected:
  void loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                 const std::string& section) override;

 private:
  void emit(const simulator::Event& event);
  void emitImage(const simulator::Event& event, int camera);
  void give(TimeNs t, const char* counter, const std::shared_ptr<mrpt::obs::CObservation>& obs);

  simulator::SimulatorOptions options_;
  std::unique_ptr<simulator::World> world_;
  std::unique_ptr<simulator::ImageWriter> writer_;
  std::vector<std::shared_ptr<const mrpt::obs::CObservationImage>>
      image_templates_;                ///< per camera
  std::size_t at_ = 0;                 ///< next event
  std::map<std::string, long> given_;  ///< observations handed out, by counter name
  std::vector<std::string> warnings_;
};

}  // namespace vir
