#include "batch/batch_key.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "batch/child_process.h"
#include "vir/roles/plugin_loader.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

/// FNV-1a, 64 bit: against mistakes, not against malice.
class Hash {
 public:
  void add(const char* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      value_ = (value_ ^ static_cast<unsigned char>(data[i])) * 0x100000001b3ULL;
    }
  }
  /// With its length, so that "ab" + "c" is not "a" + "bc".
  void add(const std::string& text) {
    const std::uint64_t size = text.size();
    add(reinterpret_cast<const char*>(&size), sizeof size);
    add(text.data(), text.size());
  }
  void addFile(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::array<char, 65536> buffer;
    while (in.read(buffer.data(), buffer.size()) || in.gcount() > 0) {
      add(buffer.data(), static_cast<std::size_t>(in.gcount()));
    }
  }
  std::string text() const {
    std::array<char, 17> text{};
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value_));
    return text.data();
  }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

/// Shared libraries of ours that this process has loaded.
std::vector<std::string> ownLibraries() {
  std::vector<std::string> files;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    const std::size_t path = line.find('/');
    if (path == std::string::npos || line.find("/libvir_", path) == std::string::npos) continue;
    files.push_back(line.substr(path));
  }
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

}  // namespace

std::string programKey(const std::string& plugin_dir) {
  std::vector<std::string> files = ownLibraries();
  files.push_back(ownProgram());
  std::vector<std::string> plugins;
  std::error_code error;
  const std::string folder = plugin_dir.empty() ? roles::defaultPluginFolder() : plugin_dir;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".so") plugins.push_back(entry.path().string());
  }
  std::sort(plugins.begin(), plugins.end());
  files.insert(files.end(), plugins.begin(), plugins.end());
  Hash hash;
  for (const std::string& file : files) hash.addFile(file);
  return hash.text();
}

std::string simulatorKey(const std::string& plugin_dir) {
  constexpr const char* kRecordings = "1";  // as the program writes them
  const fs::path folder = plugin_dir.empty() ? roles::defaultPluginFolder() : plugin_dir;
  Hash hash;
  hash.add(kRecordings);
  hash.addFile((folder / "libvir_plugin_simulator.so").string());
  // What it is linked to where libraries are shared objects.
  const fs::path libraries = folder.parent_path().parent_path();
  for (const char* name :
       {"core", "geometry", "types", "camera", "imu", "rendering", "simulation", "rawlog"}) {
    hash.addFile((libraries / ("libvir_" + std::string(name) + ".so")).string());
  }
  return hash.text();
}

std::string keyOf(const std::string& before, const std::vector<std::string>& files,
                  const std::vector<std::string>& arguments) {
  Hash hash;
  hash.add(before);
  for (const std::string& file : files) hash.addFile(file);
  for (const std::string& argument : arguments) hash.add(argument);
  return hash.text();
}

std::string sizeText(const std::string& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  if (error) return "";
  const auto when = fs::last_write_time(file, error).time_since_epoch().count();
  return std::to_string(size) + " " + std::to_string(when);
}

}  // namespace vir::app
