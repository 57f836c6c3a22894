#include "vir/core/scratch_folder.h"

#include <cstdlib>
#include <stdexcept>
#include <system_error>

namespace vir {
inline namespace core {
namespace fs = std::filesystem;

ScratchFolder::ScratchFolder(const std::string& name) {
  std::error_code none;
  const fs::path place = fs::temp_directory_path(none);
  std::string pattern = (place / (name + "-XXXXXX")).string();
  if (none || mkdtemp(pattern.data()) == nullptr) {
    throw std::runtime_error("no folder can be made for temporary files" +
                             (none ? "" : " in " + place.string()) +
                             ": set TMPDIR to one that can be written to");
  }
  path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace core
}  // namespace vir
