#include "recordings/source_reader.h"

#include <filesystem>

#include "commands/commands.h"
#include "recordings/import_job.h"
#include "vir/core/settings.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir/roles/recorded_source.h"
#include "vir/roles/sensor_registry.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

using Visit = std::function<void(mrpt::obs::CObservation&, double)>;

std::vector<std::string> readRawlog(const std::string& path, const Visit& visit) {
  rawlog::RawlogReader reader(path);
  while (const auto o = reader.next()) visit(*o, reader.progress());
  std::vector<std::string> out;
  for (const std::string& problem : {reader.damage(), reader.refusals()}) {
    if (!problem.empty()) out.push_back(problem);
  }
  return out;
}

}  // namespace

bool isRawlog(const std::string& source) {
  const fs::path path(source);
  return path.extension() == ".rawlog" ||
         (path.extension() == ".gz" && path.stem().extension() == ".rawlog");
}

std::vector<std::string> readSource(const SourceToRead& what, const Visit& visit) {
  if (!fs::exists(what.source)) {
    throw UsageError("there is no such file or folder: " + what.source);
  }
  if (isRawlog(what.source)) return readRawlog(what.source, visit);
  const std::string driver = driverThatReads(what.source);
  if (driver.empty())
    throw UsageError(what.source + ": no driver knows this kind of file or folder");
  const auto sensor = roles::createSensor(driver);
  auto* source = dynamic_cast<roles::RecordedSource*>(sensor.get());
  if (source == nullptr) throw UsageError("'" + driver + "' is a live sensor");
  Settings settings;
  // Without a folder for images they stay in memory.
  for (const std::string& assignment : what.set) settings.set(assignment);
  if (!what.calibration.empty()) settings.set(driver + ".calibration=" + what.calibration);
  settings.set(driver + ".source=" + what.source);
  SettingsReader reader(settings);
  source->describe(reader);
  reader.finish();
  sensor->initialize();
  bool more = true;
  while (more) {
    more = !source->finished();
    if (more) sensor->doProcess();
    for (const auto& [stamp, object] : sensor->getObservations()) {
      if (auto* o = dynamic_cast<mrpt::obs::CObservation*>(object.get())) {
        visit(*o, source->progress());
      }
    }
  }
  return source->warnings();
}

}  // namespace vir::app
