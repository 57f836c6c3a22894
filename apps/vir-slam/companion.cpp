#include "companion.h"

#include <filesystem>
#include <fstream>

namespace vir::app {

std::string companionOf(const std::string& rawlog) {
  const std::string path = std::filesystem::path(rawlog).replace_extension(".ini").string();
  std::ifstream in(path);
  std::string first;
  std::getline(in, first);
  return first.rfind("// Written by vir-slam import", 0) == 0 ? path : "";
}

}  // namespace vir::app
