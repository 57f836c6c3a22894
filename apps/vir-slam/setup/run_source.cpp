#include "setup/run_source.h"

#include <filesystem>

#include "output/console.h"
#include "recordings/import_job.h"
#include "recordings/source_reader.h"
#include "vir/core/text_file.h"
#include "vir/results/results_folder.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

/// Settings of the sensor go to the import, others to the run.
void splitSettings(const std::string& driver, std::vector<std::string>* run,
                   std::vector<std::string>* import) {
  std::vector<std::string> rest;
  for (const std::string& s : *run) {
    (s.rfind(driver + ".", 0) == 0 ? *import : rest).push_back(s);
  }
  run->swap(rest);
}

}  // namespace

void resolveSource(const RunSource& source, Common& common, RunArguments* arguments) {
  if (isRawlog(source.what)) {
    if (!arguments->rawlog.empty()) {
      throw UsageError("two recordings: " + source.what + " and --rawlog " + arguments->rawlog);
    }
    requireFile(source.what, "rawlog");
    arguments->rawlog = source.what;
    return;
  }
  if (notAFile(source.what) == "a device") {
    throw UsageError(source.what + " is a device, neither settings nor a recording");
  }
  // Empty settings leave all as it is.
  if (arguments->rawlog.empty() || !fs::exists(source.what)) requireSource(source.what);
  std::string driver;
  // Not for settings: the sensors' plugins bring MRPT's drivers with them.
  const bool settings =
      fs::path(source.what).extension() == ".ini" && !fs::is_directory(source.what);
  if (!settings && fs::exists(source.what)) {
    loadPlugins(common, {roles::PluginRole::sensor});
    driver = driverThatReads(source.what);
  }
  if (driver.empty() && fs::is_directory(source.what)) {
    throw UsageError(source.what +
                     ": is a folder of which no driver knows the kind; `vir-slam "
                     "import DRIVER " +
                     source.what + "` tells more");
  }
  if (driver.empty()) {
    if (!source.topics.empty()) {
      throw UsageError("--topic is for a recording that is imported; " + source.what + " is none");
    }
    arguments->ini = source.what;
    return;
  }
  if (!arguments->rawlog.empty()) {
    throw UsageError("two recordings: " + source.what + " and --rawlog " + arguments->rawlog);
  }
  const results::ResultsFolder folder(arguments->out);
  arguments->out = folder.path();
  ImportJob job;
  job.driver = driver;
  job.source = source.what;
  job.out = folder.file("recording.rawlog");
  job.calibration = arguments->calibration;
  job.topics = source.topics;
  splitSettings(driver, &arguments->assignments, &job.set);
  catchInterrupt();
  if (!importRecording(job)) common.exit_code = kRunFailed;
  arguments->rawlog = job.out;
}

}  // namespace vir::app
