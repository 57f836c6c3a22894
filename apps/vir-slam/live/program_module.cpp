#include "live/program_module.h"

#include <dlfcn.h>

#include <filesystem>
#include <stdexcept>
#include <string>

#include "vir/roles/plugin_loader.h"

namespace vir::app {
namespace {

std::string reasonOfLinker() {
  const char* reason = dlerror();
  return reason != nullptr ? reason : "unknown reason";
}

}  // namespace

void* functionOf(const char* object, const char* name) {
  const std::filesystem::path plugins = roles::defaultPluginFolder();
  const std::string file = (plugins.parent_path() / object).string();
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) throw std::runtime_error(reasonOfLinker());
  void* function = dlsym(library, name);
  if (function == nullptr) throw std::runtime_error(reasonOfLinker());
  return function;
}

void* functionOfDds(const char* name) {
  try {
    return functionOf("libvir_dds_module.so", name);
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(
        std::string("[Dds] asks for DDS, which this program was built without (build it with "
                    "cyclonedds-dev and cyclonedds-tools installed): ") +
        e.what());
  }
}

}  // namespace vir::app
