#include "recordings/import_job.h"

#include <filesystem>

#include "recordings/rawlog_recorder.h"
#include "setup/given_calibration.h"
#include "vir/core/settings.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

std::string recordedDrivers() {
  std::string out;
  for (const roles::SensorEntry& e : roles::registeredSensors()) {
    if (e.alias == "simulator" || roles::openSensor(e.alias)->recorded() == nullptr) continue;
    out += (out.empty() ? "" : ", ") + e.alias + " (" + e.description + ")";
  }
  return out;
}

OpenedSource find(const ImportJob& job) {
  requireSource(job.source);
  OpenedSource opened;
  opened.driver = job.driver.empty() ? driverThatReads(job.source) : job.driver;
  if (opened.driver.empty()) {
    throw UsageError(job.source + ": no driver knows this kind of file or folder; those for " +
                     "recordings are " + recordedDrivers() + "; `vir-slam import DRIVER " +
                     job.source + "` says what one of them lacks");
  }
  opened.sensor = roles::openSensor(opened.driver);
  opened.source = opened.sensor->recorded();
  if (opened.source == nullptr) {
    throw UsageError("'" + opened.driver + "' is a live sensor; use `vir-slam record`");
  }
  return opened;
}

/// Configures the sensor as its section [alias], --topic, --calibration and --set say.
void configure(const ImportJob& job, const OpenedSource& opened) {
  Settings settings;
  const std::string prefix = opened.driver + ".";
  std::string topics;
  for (const std::string& t : job.topics) topics += (topics.empty() ? "" : " ") + t;
  if (!topics.empty()) settings.set(prefix + "topics=" + topics);
  if (!job.calibration.empty()) settings.set(prefix + "calibration=" + job.calibration);
  for (const std::string& assignment : job.set) settings.set(assignment);
  settings.set(prefix + "source=" + job.source);
  SettingsReader reader(settings);
  opened.source->describe(reader);
  reader.finish();
}

}  // namespace

void requireSource(const std::string& source) {
  std::error_code ec;
  if (!fs::exists(source, ec)) {
    for (const roles::SensorEntry& e : roles::registeredSensors()) {
      if (e.alias != source) continue;
      throw UsageError(
          "'" + e.alias + "' is a driver; name the recording as well: vir-slam import " + e.alias +
          " SOURCE --out FILE.rawlog (its settings: vir-slam import " + e.alias + " --help)");
    }
    throw UsageError("there is no such file or folder: " + source);
  }
  if (fs::is_regular_file(source, ec) && fs::file_size(source, ec) == 0 && !ec) {
    throw UsageError(source + " is empty");
  }
}

OpenedSource openSource(const ImportJob& job) {
  OpenedSource opened = find(job);
  configure(job, opened);
  return opened;
}

std::string driverThatReads(const std::string& source) {
  std::string found;
  for (const roles::SensorEntry& e : roles::registeredSensors()) {
    const auto sensor = roles::openSensor(e.alias);
    const roles::RecordedSource* recorded = sensor->recorded();
    if (recorded == nullptr || !recorded->canRead(source)) continue;
    if (!found.empty()) {
      throw UsageError(source + ": both '" + found + "' and '" + e.alias +
                       "' can read it; name one: vir-slam import " + found + " " + source);
    }
    found = e.alias;
  }
  return found;
}

bool importRecording(const ImportJob& job) {
  if (job.driver == "simulator") {
    throw UsageError("'simulator' has no recording to import; use `vir-slam simulate INI`");
  }
  requireRawlogName(job.out);
  requireCalibration(job.calibration);
  const OpenedSource opened = openSource(job);
  return recordToRawlog({opened.sensor.get(), opened.source, job.out, job.compression, "import",
                         opened.driver, job.stereo});
}

std::string listRecording(const ImportJob& job) {
  const OpenedSource opened = find(job);
  const std::string text = opened.source->listing(job.source);
  if (text.empty()) throw UsageError("'" + opened.driver + "' has no list of what is in a source");
  return text;
}

}  // namespace vir::app
