#pragma once
/// Sensors "euroc" and "csv": folders of tables and images as MRPT observations.
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

/// Gives CAM0, IMU0, UWB0 (CAM1, UWB1, ...) and GT in time order, as fast as doProcess() is called.
/// Memory does not depend on the recording's length. The label set for the sensor is not used: one
/// folder holds several sensors, which keep their own.
class FolderSource : public mrpt::hwdrivers::CGenericSensor, public roles::RecordedSource {
 public:
  /// `section`: the driver's name on our command line.
  explicit FolderSource(const std::string& section);
  ~FolderSource() override;

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
  std::vector<SurveyedAnchor> surveyedAnchors() const override;

 protected:
  void loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                 const std::string& section) override;
  virtual std::unique_ptr<euroc::Recording> openRecording(const euroc::EurocOptions& options,
                                                          ProblemLog* log) const = 0;

 private:
  struct Camera {
    std::unique_ptr<euroc::ImageStore> store;
    std::shared_ptr<const mrpt::obs::CObservationImage> image_template;
    std::string dir, label;
  };

  void openCamera(const euroc::CameraStream& stream, euroc::ImageMode mode);
  void emit(const euroc::Event& event);
  void emitImage(const euroc::Event& event, const euroc::ImageRow& row);
  void finish();

  euroc::EurocOptions options_;
  ProblemLog log_;
  std::unique_ptr<euroc::Recording> recording_;
  std::vector<Camera> cameras_;
  std::map<std::string, long> given_;  ///< observations handed out, by counter name
  bool finished_ = false;
};

class EurocDataset : public FolderSource {
  DEFINE_GENERIC_SENSOR(EurocDataset)
 public:
  EurocDataset() : FolderSource("euroc") {}
  bool canRead(const std::string& source) const override { return euroc::isFolder(source); }

 protected:
  std::unique_ptr<euroc::Recording> openRecording(const euroc::EurocOptions& options,
                                                  ProblemLog* log) const override;
};

class CsvDataset : public FolderSource {
  DEFINE_GENERIC_SENSOR(CsvDataset)
 public:
  CsvDataset() : FolderSource("csv") {}
  bool canRead(const std::string& source) const override;
  std::string listing(const std::string& source) const override;

 protected:
  std::unique_ptr<euroc::Recording> openRecording(const euroc::EurocOptions& options,
                                                  ProblemLog* log) const override;
};

}  // namespace vir
