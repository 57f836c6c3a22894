#pragma once
/// A place for files that nobody needs afterwards.
#include <filesystem>
#include <string>

namespace vir {
inline namespace core {

/// An empty folder beside other temporary files (TMPDIR); it goes with this, and what is in it.
class ScratchFolder {
 public:
  /// `name` begins the folder's name. Throws std::runtime_error where none can be made.
  explicit ScratchFolder(const std::string& name);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace core
}  // namespace vir
