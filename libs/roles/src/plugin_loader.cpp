#include "vir/roles/plugin_loader.h"

#include <dlfcn.h>
#include <mrpt/system/os.h>

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <set>

#include "registry.h"

namespace vir::roles {
namespace fs = std::filesystem;
namespace {

std::mutex& loaderMutex() {
  static std::mutex mutex;
  return mutex;
}

std::set<std::string>& loadedFiles() {
  static std::set<std::string> files;
  return files;
}

/// MRPT binds lazily, so that an undefined symbol would end the program when it is first called:
/// bind at once, before MRPT sees the file.
void openStrictly(const std::string& file) {
  dlerror();
  if (dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL) != nullptr) return;
  const char* reason = dlerror();
  throw PluginError("cannot load plugin " + file + ": " +
                    (reason != nullptr ? reason : "unknown reason"));
}

}  // namespace

void loadPlugin(const std::string& file) {
  const std::lock_guard<std::mutex> lock(loaderMutex());
  std::error_code error;
  if (!fs::exists(file, error)) throw PluginError("there is no plugin file " + file);
  // With a folder in front the dynamic linker takes the file as named and searches nowhere else.
  const std::string path = fs::canonical(file).string();
  if (loadedFiles().count(path) > 0) return;

  registry::setCurrentPlugin(path);
  const std::size_t before = registry::size();
  std::string mrpt_error;
  try {
    openStrictly(path);
  } catch (...) {
    registry::setCurrentPlugin("");
    throw;
  }
  const bool known_to_mrpt = mrpt::system::loadPluginModule(path, mrpt_error);
  registry::setCurrentPlugin("");
  if (!known_to_mrpt) throw PluginError("cannot load plugin " + path + ": " + mrpt_error);

  std::string problems;
  for (const std::string& problem : registry::takeProblems()) {
    problems += (problems.empty() ? "" : "; ") + problem;
  }
  if (!problems.empty()) throw PluginError("plugin " + path + ": " + problems);
  if (registry::size() == before) {
    throw PluginError("plugin " + path +
                      " registers nothing: it needs VIR_REGISTER_SENSOR, VIR_REGISTER_ESTIMATOR "
                      "or VIR_REGISTER_RENDEZVOUS");
  }
  loadedFiles().insert(path);
}

std::vector<std::string> loadPluginFolder(const std::string& folder, const PluginRoles& roles) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw PluginError("there is no plugin folder " + folder + "; name one with --plugin-dir");
  }
  std::vector<std::string> files;
  for (const auto& item : fs::directory_iterator(folder)) {
    if (item.path().extension() != ".so") continue;
    const PluginRoles has = rolesOfPlugin(item.path().string());
    const bool wanted =
        std::any_of(has.begin(), has.end(), [&](PluginRole role) { return roles.count(role) > 0; });
    if (wanted) files.push_back(item.path().string());
  }
  std::sort(files.begin(), files.end());
  for (const std::string& file : files) loadPlugin(file);
  return files;
}

std::string defaultPluginFolder() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (error) throw PluginError("cannot find this program's own folder: " + error.message());
  return (self.parent_path().parent_path() / "lib" / "vir-slam" / "plugins").string();
}

}  // namespace vir::roles
