#pragma once
/// Sensors "bag" and "rosbag2": recordings of ROS 1 and ROS 2 as MRPT observations.
#include <mrpt/hwdrivers/CGenericSensor.h>
#include <mrpt/obs/obs_frwds.h>

#include <deque>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bag_recording.h"
#include "vir/roles/recorded_source.h"

namespace vir {

/// Gives what was chosen of the bag in time order, as fast as doProcess() is called. The label set
/// for the sensor is not used: a bag holds several sensors, which have labels of their own.
class BagSource : public mrpt::hwdrivers::CGenericSensor, public roles::RecordedSource {
 public:
  /// `section`: the driver's name on our command line.
  explicit BagSource(std::string section);
  ~BagSource() override;

  // CGenericSensor
  void initialize() override;
  void doProcess() override;
  void setPathForExternalImages(const std::string& directory) override;

  // RecordedSource
  void describe(OptionVisitor& v) override;
  double progress() const override;
  bool finished() const override { return finished_; }
  std::vector<std::pair<std::string, long>> counters() const override;
  std::vector<std::string> warnings() const override { return log_.messages(); }
  std::string companionIni() const override;
  std::vector<SurveyedAnchor> surveyedAnchors() const override;
  std::string listing(const std::string& source) const override;

 protected:
  void loadConfig_sensorSpecific(const mrpt::config::CConfigFileBase& config,
                                 const std::string& section) override;

 private:
  void emit(bag::Reading* reading);
  mrpt::obs::CObservation::Ptr imageObservation(TimeNs t, bag::ImageReading* image,
                                                const std::string& label,
                                                std::future<void>* written);
  std::future<void> writeLater(const std::string& path, bag::ImageReading* image) const;
  void release(std::size_t most_waiting);
  void finish();

  /// What waits, in order, for the file of an image to be there.
  struct Waiting {
    mrpt::obs::CObservation::Ptr observation;
    std::future<void> written;  ///< not valid: nothing to wait for
  };

  std::string section_;
  bag::BagOptions options_;
  ProblemLog log_;
  std::unique_ptr<bag::BagRecording> recording_;
  std::vector<std::shared_ptr<const mrpt::obs::CObservationImage>> templates_;  // by camera
  std::map<std::string, long> given_;
  std::deque<Waiting> waiting_;
  std::size_t files_waited_for_ = 0;
  bool finished_ = false, embed_ = false, folder_ready_ = false;
};

class Ros1Bag : public BagSource {
  DEFINE_GENERIC_SENSOR(Ros1Bag)
 public:
  Ros1Bag() : BagSource("bag") {}
  bool canRead(const std::string& source) const override;
};

class Ros2Bag : public BagSource {
  DEFINE_GENERIC_SENSOR(Ros2Bag)
 public:
  Ros2Bag() : BagSource("rosbag2") {}
  bool canRead(const std::string& source) const override;
};

}  // namespace vir
