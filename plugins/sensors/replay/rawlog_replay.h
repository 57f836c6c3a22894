#pragma once
/// Sensor "replay": a rawlog that comes in as if live.
#include <mrpt/hwdrivers/CGenericSensor.h>

#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "vir/core/time.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir/roles/recorded_source.h"

namespace vir {

struct ReplayOptions {
  std::string rawlog;
  std::string labels;  ///< with blanks between; empty = all
  double speed = 1;
  double start_at_s = 0;
  std::string stamps = "keep";
};
void describe(OptionVisitor& v, ReplayOptions& o);

/// Hands out the observations of a rawlog with the pauses they were recorded with. Several
/// instances on one file (a camera, an IMU, ... each in its thread) play in step: the time of the
/// first object is the start of the first instance. Damage of the file ends it with an error.
class RawlogReplay : public mrpt::hwdrivers::CGenericSensor, public roles::RecordedSource {
  DEFINE_GENERIC_SENSOR(RawlogReplay)
 public:
  RawlogReplay();
  ~RawlogReplay() override;

  // CGenericSensor
  /// Throws std::runtime_error if the file cannot be opened.
  void initialize() override;
  void doProcess() override;

  // RecordedSource
  void describe(OptionVisitor& v) override;
  double progress() const override;
  bool finished() const override { return finished_; }
  std::vector<std::pair<std::string, long>> counters() const override;
  std::vector<std::string> warnings() const override { return warnings_; }

 protected:
  void loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                 const std::string& section) override;

 private:
  struct Start;
  void readOn();
  bool wanted(const mrpt::obs::CObservation& observation) const;

  ReplayOptions options_;
  std::set<std::string> labels_;
  std::unique_ptr<rawlog::RawlogReader> reader_;
  std::shared_ptr<Start> start_;
  mrpt::obs::CObservation::Ptr next_;
  bool finished_ = false;
  std::map<std::string, long> given_;
  std::vector<std::string> warnings_;
};

}  // namespace vir
