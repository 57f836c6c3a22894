#include "more_classes.h"

#include <dlfcn.h>
#include <link.h>
#include <mrpt/rtti/CObject.h>

#include <cctype>
#include <cstring>

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

/// MRPT's library `module` of the version that is loaded, beside its library of observations; empty
/// if that cannot be found.
std::string fileOf(const std::string& module) {
  std::string obs;
  const auto look = [](dl_phdr_info* info, std::size_t, void* found) {
    if (std::strstr(info->dlpi_name, "libmrpt-obs.") == nullptr) return 0;
    *static_cast<std::string*>(found) = info->dlpi_name;
    return 1;
  };
  dl_iterate_phdr(look, &obs);
  const std::size_t at = obs.rfind("obs.");
  return at == std::string::npos ? obs : obs.replace(at, 3, module);
}

}  // namespace

bool loadClassNamedIn(const std::string& reason) {
  const std::string name = unknownClassIn(reason);
  if (name.empty()) return false;
  for (const char* module : {"maps", "vision"}) {
    if (mrpt::rtti::findRegisteredClass(name) != nullptr) break;
    const std::string file = fileOf(module);
    if (!file.empty()) dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);  // never closed: classes stay
  }
  return mrpt::rtti::findRegisteredClass(name) != nullptr;
}

}  // namespace vir::rawlog
