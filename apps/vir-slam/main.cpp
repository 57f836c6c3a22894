#include <malloc.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <new>
#include <opencv2/core/utility.hpp>

#include "commands/commands.h"
#include "commands/words.h"
#include "vir/core/loaded_pages.h"
#include "vir/core/settings.h"
#include "vir/core/text_file.h"
#include "vir/rawlog/mrpt_error.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir/roles/plugin_loader.h"

namespace vir::app {
namespace {

constexpr const char* kExamples = R"(Examples:
  vir-slam import euroc MH_01_easy --out mh01.rawlog
  vir-slam check mh01.rawlog
  vir-slam run ini/euroc.ini --rawlog mh01.rawlog --out results/mh01
  vir-slam simulate ini/simulate_two_robots.ini --out two.rawlog
  vir-slam evaluate --reference groundtruth.tum results/mh01/trajectory.tum
  vir-slam plugins

Visual-inertial(-ranging) SLAM on MRPT rawlogs.)";

/// One line per subcommand.
constexpr void (*kCommands[])(CLI::App&, Common&) = {
    addRun,       addView,  addRendezvous, addImport, addCheck, addSimulate, addEvaluate,
    addCalibrate, addBatch, addRecord,     addExport, addMap,   addPlugins,
};

int fail(int code, const std::string& text) {
  std::fprintf(stderr, "vir-slam: %s\n", text.c_str());
  return code;
}

int dispatch(int argc, char** argv) {
  CLI::App app(kExamples, "vir-slam");
  Common common;
  app.set_version_flag("-V,--version", "vir-slam " VIR_VERSION);
  app.add_option("--plugin-dir", common.plugin_dir,
                 "Folder with the plugins (default: lib/vir-slam/plugins beside the program)");
  app.add_flag_callback(
      "--images-elsewhere", [] { rawlog::allowImagesElsewhere(true); },
      "Read images that a rawlog names outside its own folder (else they are refused)");
  app.add_flag("--force", common.force,
               "Write also over files that are not what the command would leave there itself");
  app.require_subcommand(1);
  app.fallthrough();
  for (const auto add : kCommands) add(app, common);
  try {
    std::vector<std::string> words = understood({argv + 1, argv + argc}, app);
    common.command = commandLine(words);
    std::reverse(words.begin(), words.end());  // CLI11 takes them from the end
    app.parse(std::move(words));
  } catch (const CLI::ParseError& e) {
    if (app.exit(e) == 0) return kOk;
    const std::string hint = optionHint(app);
    return hint.empty() ? kUsage : fail(kUsage, hint);
  } catch (const SettingsError& e) {
    return fail(kUsage, e.what());
  } catch (const UsageError& e) {
    return fail(kUsage, e.what());
  } catch (const roles::PluginError& e) {
    return fail(kUsage, e.what());
  } catch (const std::bad_alloc&) {
    return fail(kRunFailed, "out of memory");
  } catch (const std::exception& e) {
    return fail(kRunFailed, rawlog::withoutStackTrace(e));
  }
  return common.exit_code;
}

/// Images come and go by the megabyte. Given back to the kernel each time, their pages are cleared
/// anew for every image: up to three quarters of `check`'s CPU time.
void keepFreedMemory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
#endif
}

/// The program's own threads (tracking, optimisation, decoding) share the cores; OpenCV's pool
/// would only spin between its short calls, and hides their CPU time from the stages'.
void useOwnThreads() { cv::setNumThreads(1); }

}  // namespace

void loadPlugins(const Common& common, const roles::PluginRoles& roles) {
  roles::loadPluginFolder(
      common.plugin_dir.empty() ? roles::defaultPluginFolder() : common.plugin_dir, roles);
  releaseLoadedPages();
}

void requireFile(const std::string& path, const std::string& what) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    throw UsageError("there is no such " + what + ": " + path);
  }
  const std::string other = notAFile(path);
  if (!other.empty()) throw UsageError("not a " + what + " but " + other + ": " + path);
  const std::string why = whyNoText(path);
  if (!why.empty()) throw UsageError("the " + what + " " + why + ": " + path);
}

}  // namespace vir::app

int main(int argc, char** argv) {
  vir::app::keepFreedMemory();
  vir::app::useOwnThreads();
  const int code = vir::app::dispatch(argc, argv);
  vir::releaseLoadedPages();  // what libraries do at the end reads code that was not needed so far
  return code;
}
