/// The half of the sensors' registry that needs MRPT's drivers: a shared library of its own
/// (vir_sensor_roles), so that who needs no sensor does not load them.
#include "vir/roles/sensor_registry.h"

#include <mrpt/system/COutputLogger.h>

#include "registry.h"
#include "vir/roles/live_source.h"
#include "vir/roles/plugin_loader.h"
#include "vir/roles/recorded_source.h"

namespace vir::roles {
namespace {

using mrpt::hwdrivers::CGenericSensor;

class MrptSensor final : public Sensor {
 public:
  explicit MrptSensor(CGenericSensor::Ptr sensor) : sensor_(std::move(sensor)) {}
  void loadConfig(const mrpt::config::CConfigFileBase& config,
                  const std::string& section) override {
    sensor_->loadConfig(config, section);
  }
  void setPathForExternalImages(const std::string& folder) override {
    sensor_->setPathForExternalImages(folder);
  }
  void initialize() override { sensor_->initialize(); }
  void doProcess() override { sensor_->doProcess(); }
  std::vector<mrpt::obs::CObservation::Ptr> takeObservations() override {
    std::vector<mrpt::obs::CObservation::Ptr> taken;
    for (const auto& [stamp, object] : sensor_->getObservations()) {
      auto observation = std::dynamic_pointer_cast<mrpt::obs::CObservation>(object);
      if (observation) taken.push_back(std::move(observation));
    }
    return taken;
  }
  bool failed() const override { return sensor_->getState() == CGenericSensor::ssError; }
  RecordedSource* recorded() override { return dynamic_cast<RecordedSource*>(sensor_.get()); }
  LiveSource* live() override { return dynamic_cast<LiveSource*>(sensor_.get()); }
  void muteConsole() override {
    auto* talker = dynamic_cast<mrpt::system::COutputLogger*>(sensor_.get());
    if (talker != nullptr) talker->logging_enable_console_output = false;
  }

 private:
  CGenericSensor::Ptr sensor_;
};

std::unique_ptr<Sensor> make(const std::string& class_name) {
  auto sensor = CGenericSensor::createSensorPtr(class_name);
  if (!sensor) return nullptr;
  return std::make_unique<MrptSensor>(std::move(sensor));
}

/// MRPT replaces a class of the same name without a word.
bool takenInMrpt(const mrpt::hwdrivers::TSensorClassId* id) {
  const auto sensor = CGenericSensor::createSensorPtr(id->className);
  return sensor != nullptr && sensor->GetRuntimeClass() != id;
}

const bool told = [] {
  registry::setSensorMaker(&make);
  return true;
}();

}  // namespace

void registerSensor(const mrpt::hwdrivers::TSensorClassId* id, const std::string& alias,
                    const std::string& description) {
  const bool added = registry::addSensor({alias, id->className, description, ""},
                                         [id] { return takenInMrpt(id); });
  if (added) CGenericSensor::registerClass(id);
}

CGenericSensor::Ptr createSensor(const std::string& name) {
  const std::string class_name = registry::sensorClass(name);
  auto sensor = CGenericSensor::createSensorPtr(class_name);
  if (!sensor) throw registry::unknownToMrpt(class_name);
  return sensor;
}

}  // namespace vir::roles
