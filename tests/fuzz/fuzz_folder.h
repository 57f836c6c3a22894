#pragma once
/// A folder of the target's own in memory, or else in the temporary folder, gone with the program
/// where that ends well. On disk a run takes ten times as long: file systems write a file that is
/// cut and written anew before they go on.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace vir::fuzz {

class Folder {
 public:
  Folder() : path_(place() / ("vir-fuzz-" + std::to_string(::getpid()))) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
    current() = path_;
    std::atexit(clearAway);
    std::at_quick_exit(clearAway);  // of VIR_FUZZ_BYTES
  }
  const std::filesystem::path& path() const { return path_; }

  void write(const std::string& name, const std::string& text) const {
    const std::filesystem::path file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
  }
  std::string read(const std::string& name) const { return readFile((path_ / name).string()); }

  static std::string readFile(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

 private:
  /// TMPDIR says otherwise.
  static std::filesystem::path place() {
    const char* const memory = "/dev/shm";
    const bool there = std::getenv("TMPDIR") == nullptr && ::access(memory, W_OK | X_OK) == 0;
    return there ? std::filesystem::path(memory) : std::filesystem::temp_directory_path();
  }
  static void clearAway() {
    std::error_code ignored;
    std::filesystem::remove_all(current(), ignored);
  }
  static std::filesystem::path& current() {
    static std::filesystem::path path;
    return path;
  }
  std::filesystem::path path_;
};

}  // namespace vir::fuzz
