#include "more_classes.h"

#include <dlfcn.h>
#include <mrpt/rtti/CObject.h>
#include <mrpt/version.h>

#include <cctype>

namespace vir::rawlog {
namespace {

/// Of `... class 'mrpt::obs::CName' which is not registered!`; empty if that is not what it says or
/// the name is none (a damaged file).
std::string unknownClassIn(const std::string& reason) {
  static const std::string kBefore = "class '", kBehind = "' which is not registered";
  const std::size_t behind = reason.find(kBehind);
  if (behind == std::string::npos) return {};
  const std::size_t before = reason.rfind(kBefore, behind);
  if (before == std::string::npos) return {};
  const std::size_t first = before + kBefore.size();
  std::string name = reason.substr(first, behind - first);
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != ':' && c != '_') return {};
  }
  return name.rfind("mrpt::", 0) == 0 || name.rfind('C', 0) == 0 ? name : std::string();
}

/// As MRPT numbers the libraries of its versions.
std::string fileOf(const char* module) {
  constexpr int kVersion = MRPT_VERSION;  // 0x258 is 2.5.8
  return "libmrpt-" + std::string(module) + ".so." + std::to_string((kVersion >> 8) & 0xf) + "." +
         std::to_string((kVersion >> 4) & 0xf);
}

}  // namespace

bool loadClassNamedIn(const std::string& reason) {
  const std::string name = unknownClassIn(reason);
  if (name.empty()) return false;
  for (const char* module : {"maps", "vision"}) {
    if (mrpt::rtti::findRegisteredClass(name) != nullptr) break;
    dlopen(fileOf(module).c_str(), RTLD_NOW | RTLD_LOCAL);  // never closed: the classes stay
  }
  return mrpt::rtti::findRegisteredClass(name) != nullptr;
}

}  // namespace vir::rawlog
