#include "recordings/source_reader.h"

#include <filesystem>

#include "commands/commands.h"
#include "recordings/import_job.h"
#include "vir/rawlog/rawlog_reader.h"

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
  if (isRawlog(what.source) && fs::exists(what.source)) return readRawlog(what.source, visit);
  ImportJob job;
  job.source = what.source;
  job.calibration = what.calibration;
  // Without a folder for images they stay in memory.
  job.set = what.set;
  const auto [sensor, source, driver] = openSource(job);
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
