#pragma once
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/obs/CObservation.h>

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "vir/core/host_clock.h"
#include "vir/core/log.h"
#include "vir/core/settings.h"
#include "vir/core/time.h"
#include "vir/types/anchor.h"
#include "vir/types/state.h"

namespace vir::live {

/// An observation as it came in.
struct Arrival {
  std::size_t sensor = 0;  ///< index into Acquisition::sensors()
  mrpt::obs::CObservation::Ptr observation;
  TimeNs arrival = 0;  ///< host's clock (Unix time)
};

enum class SensorState {
  starting,
  running,
  waiting,  ///< to be started again, or for its device
  ended,
  missing  ///< it has never worked
};
const char* name(SensorState state);

/// How a sensor is doing.
struct SensorStatus {
  std::string name;    ///< the ini's section
  std::string driver;  ///< class
  SensorState state = SensorState::starting;
  std::string problem;  ///< the last one; empty if there was none
  long observations = 0;
  int restarts = 0;
  /// What came in and what could not be used, by name, where the driver tells (LiveSource).
  std::vector<std::pair<std::string, long>> counters;
  bool clock_mapped = false;  ///< its stamps are put on the host's clock
};

struct AcquisitionOptions {
  double first_retry_s = 0.5, last_retry_s = 8;  ///< pause before a failed sensor is started again
  /// Stamps farther than this from the host's clock belong to a clock of the device's own.
  TimeNs own_clock_beyond = 500'000'000;
};

/// The sensors of a rawlog-grabber ini, each in its own thread: every section with a `driver` is an
/// instance of that class (MRPT's or a plugin's), `process_rate` the calls per second. Beside the
/// driver's own keys a section may say
///   optional = true|false   recording goes on without it if it is missing at the start
///   clock = auto|keep|device   its stamps: on the host's clock already unless they are far from it
///                              (auto); as they are; of a clock of its own, to be put on the host's
/// A sensor that fails later is started again, with growing pauses, while the others go on.
class Acquisition {
 public:
  /// Creates the sensors and reads their settings. Throws SettingsError or PluginError.
  Acquisition(const Settings& settings, const std::string& image_folder,
              const AcquisitionOptions& options, LogSink log);
  /// Stops.
  ~Acquisition();

  /// Initialises all sensors at the same time and starts their threads. Throws std::runtime_error
  /// naming those that are missing and not optional; then nothing runs.
  void start();
  /// Waits up to `timeout` for input and takes all there is, in order of arrival per sensor.
  std::vector<Arrival> take(TimeNs timeout);
  /// All sensors have come to their end (recordings that are played).
  bool ended() const;
  /// Ends the threads; take() gives what is left afterwards.
  void stop();
  std::vector<SensorStatus> sensors() const;
  /// For sensors that carry to others what this robot estimates (LiveSource::tell()); `anchors` as
  /// believed now, asked only where there are such. Any thread.
  void tell(const StateEstimate& estimate, const std::function<std::vector<Anchor>()>& anchors);

 private:
  class Sensor;
  /// A comment for the recording when the host's clock has been set; else empty.
  mrpt::obs::CObservation::Ptr clockNote(TimeNs now);
  void deliver(std::vector<Arrival>* arrivals);

  AcquisitionOptions options_;
  TimeNs clock_step_ = 0;
  mutable std::mutex log_mutex_;
  LogSink log_;
  std::vector<std::unique_ptr<Sensor>> sensors_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<Arrival> queue_;
};

/// Names of the sections of an ini that are sensors, in the order of the file.
std::vector<std::string> sensorSections(const Settings& settings);

}  // namespace vir::live
