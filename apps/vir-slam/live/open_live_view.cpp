#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "live/live_view.h"
#include "vir/roles/plugin_loader.h"

namespace vir::app {
namespace {

/// Beside the folder of the plugins.
std::string fileOfView() {
  const std::filesystem::path plugins = roles::defaultPluginFolder();
  return (plugins.parent_path() / "libvir_live_view.so").string();
}

std::string reasonOfLinker() {
  const char* reason = dlerror();
  return reason != nullptr ? reason : "unknown reason";
}

}  // namespace

std::unique_ptr<LiveView> openLiveView() {
  // MRPT would wait for seconds and then go on with a window that is none.
  const char* display = std::getenv("DISPLAY");
  if (display == nullptr || *display == '\0') throw std::runtime_error("there is no display");
  void* library = dlopen(fileOfView().c_str(), RTLD_NOW | RTLD_LOCAL);  // never closed
  if (library == nullptr) throw std::runtime_error(reasonOfLinker());
  auto* open = reinterpret_cast<LiveView* (*)()>(dlsym(library, "virOpenLiveView"));
  if (open == nullptr) throw std::runtime_error(reasonOfLinker());
  return std::unique_ptr<LiveView>(open());
}

}  // namespace vir::app
