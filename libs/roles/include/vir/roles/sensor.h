#pragma once
/// Role "sensor" as the program sees it: nothing here needs MRPT's drivers, of which the library
/// vir_sensor_roles and the plugins linked to it bring some 170 shared libraries into the process.
#include <mrpt/obs/CObservation.h>

#include <memory>
#include <string>
#include <vector>

namespace mrpt::config {
class CConfigFileBase;
}

namespace vir::roles {

class LiveSource;
class RecordedSource;

struct SensorEntry {
  std::string alias;        ///< name on our command line, lower case, e.g. "euroc"
  std::string class_name;   ///< MRPT class name without namespace, `driver =` in an ini
  std::string description;  ///< one line
  std::string plugin_file;  ///< path of the shared object; empty if linked in
};

/// All sensors registered so far, ordered by alias.
std::vector<SensorEntry> registeredSensors();

/// An mrpt::hwdrivers::CGenericSensor; the names are those of its members.
class Sensor {
 public:
  virtual ~Sensor() = default;
  virtual void loadConfig(const mrpt::config::CConfigFileBase& config,
                          const std::string& section) = 0;
  virtual void setPathForExternalImages(const std::string& folder) = 0;
  virtual void initialize() = 0;
  virtual void doProcess() = 0;
  /// What it handed over since the last call, by stamp; what is no observation is left out.
  virtual std::vector<mrpt::obs::CObservation::Ptr> takeObservations() = 0;
  /// Its state is ssError.
  virtual bool failed() const = 0;
  /// What it offers beside; null if it does not. Lives as long as the sensor.
  virtual RecordedSource* recorded() = 0;
  virtual LiveSource* live() = 0;
  /// It writes nothing to the terminal by itself any more.
  virtual void muteConsole() = 0;
};

/// Creates a sensor of a plugin by alias or class name (aliases case-insensitive). Throws
/// PluginError (plugin_loader.h) that lists what is available.
std::unique_ptr<Sensor> openSensor(const std::string& name);

/// Creates a sensor by its class, MRPT's own ones included; null if MRPT knows no such class. Loads
/// MRPT's drivers; throws PluginError if they are not there.
std::unique_ptr<Sensor> openMrptSensor(const std::string& class_name);

}  // namespace vir::roles
