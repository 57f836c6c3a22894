#pragma once
/// Sensor "euroc": a recording in the EuRoC (ASL) folder layout as MRPT observations.
#include <mrpt/hwdrivers/CGenericSensor.h>
#include <mrpt/obs/obs_frwds.h>

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "euroc_options.h"
#include "image_store.h"
#include "recording.h"
#include "vir/roles/recorded_source.h"

namespace vir {

/// Gives CAM0, IMU0, UWB0 and GT in time order, as fast as doProcess() is called. Memory does not
/// depend on the recording's length. The label set for the sensor is not used: one folder holds
/// several sensors, which keep their own.
class EurocDataset : public mrpt::hwdrivers::CGenericSensor, public roles::RecordedSource {
  DEFINE_GENERIC_SENSOR(EurocDataset)
 public:
  EurocDataset();
  ~EurocDataset() override;

  // CGenericSensor
  void initialize() override;
  void doProcess() override;
  /// Where external images go. Not called: images are embedded.
  void setPathForExternalImages(const std::string& directory) override;

  // RecordedSource
  void describe(OptionVisitor& v) override;
  double progress() const override;
  bool finished() const override { return finished_; }
  std::vector<std::pair<std::string, long>> counters() const override;
  std::vector<std::string> warnings() const override;
  std::string companionIni() const override;
  std::vector<roles::TrueAnchor> trueAnchors() const override;
  bool canRead(const std::string& source) const override { return euroc::isFolder(source); }

 protected:
  void loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                 const std::string& section) override;

 private:
  void emit(const euroc::Event& event);
  void emitImage(const euroc::Event& event, const euroc::ImageRow& row);
  void finish();

  euroc::EurocOptions options_;
  ProblemLog log_;
  std::unique_ptr<euroc::Recording> recording_;
  std::unique_ptr<euroc::ImageStore> store_;
  std::shared_ptr<const mrpt::obs::CObservationImage> image_template_;
  std::map<std::string, long> given_;  ///< observations handed out, by counter name
  bool finished_ = false;
};

}  // namespace vir
