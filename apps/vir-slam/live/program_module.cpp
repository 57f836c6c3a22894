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

}  // namespace vir::app
