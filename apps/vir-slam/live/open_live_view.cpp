#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "live/live_view.h"
#include "vir/roles/plugin_loader.h"

namespace vir::app {
namespace {

std::string reasonOfLinker() {
  const char* reason = dlerror();
  return reason != nullptr ? reason : "unknown reason";
}

/// The function `name` of a shared object beside the folder of the plugins, which is never closed.
void* functionOf(const char* object, const char* name) {
  const std::filesystem::path plugins = roles::defaultPluginFolder();
  const std::string file = (plugins.parent_path() / object).string();
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) throw std::runtime_error(reasonOfLinker());
  void* function = dlsym(library, name);
  if (function == nullptr) throw std::runtime_error(reasonOfLinker());
  return function;
}

}  // namespace

std::unique_ptr<LiveView> openLiveView() {
  // MRPT would wait for seconds and then go on with a window that is none.
  const char* display = std::getenv("DISPLAY");
  if (display == nullptr || *display == '\0') throw std::runtime_error("there is no display");
  auto* open =
      reinterpret_cast<LiveView* (*)()>(functionOf("libvir_live_view.so", "virOpenLiveView"));
  return std::unique_ptr<LiveView>(open());
}

std::unique_ptr<LiveView> openVideoView(const std::string& file, double speed) {
  auto* open = reinterpret_cast<LiveView* (*)(const std::string&, double)>(
      functionOf("libvir_video_view.so", "virOpenVideoView"));
  return std::unique_ptr<LiveView>(open(file, speed));
}

}  // namespace vir::app
