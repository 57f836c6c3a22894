#include "cyclone/security.h"

#include <dlfcn.h>

#include <filesystem>

namespace vir::dds {
namespace {

namespace fs = std::filesystem;

/// Debian has these libraries in a folder of Cyclone DDS beside it (libddsc0debian), where the
/// linker does not look.
std::string libraryOf(const std::string& name) {
  Dl_info info{};
  if (dladdr(reinterpret_cast<void*>(&dds_create_participant), &info) == 0 ||
      info.dli_fname == nullptr) {
    return name;
  }
  const fs::path folder = fs::path(info.dli_fname).parent_path();
  const std::string file = "lib" + name + ".so";
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
    const bool ours = entry.path().filename().string().rfind("libddsc", 0) == 0;
    if (ours && fs::exists(entry.path() / file, none)) return (entry.path() / file).string();
  }
  return fs::exists(folder / file, none) ? (folder / file).string() : name;
}

void setPlugin(dds_qos_t* qos, const std::string& part, const std::string& library,
               const std::string& function) {
  const std::string key = "dds.sec." + part + ".library.";
  dds_qset_prop(qos, (key + "path").c_str(), libraryOf(library).c_str());
  dds_qset_prop(qos, (key + "init").c_str(), ("init_" + function).c_str());
  dds_qset_prop(qos, (key + "finalize").c_str(), ("finalize_" + function).c_str());
}

}  // namespace

void secure(dds_qos_t* qos, const std::string& folder) {
  setPlugin(qos, "auth", "dds_security_auth", "authentication");
  setPlugin(qos, "crypto", "dds_security_crypto", "crypto");
  setPlugin(qos, "access", "dds_security_ac", "access_control");
  constexpr const char* kFiles[][2] = {
      {"dds.sec.auth.identity_ca", "identity_ca.cert.pem"},
      {"dds.sec.auth.identity_certificate", "cert.pem"},
      {"dds.sec.auth.private_key", "key.pem"},
      {"dds.sec.access.permissions_ca", "permissions_ca.cert.pem"},
      {"dds.sec.access.governance", "governance.p7s"},
      {"dds.sec.access.permissions", "permissions.p7s"},
  };
  for (const auto& [property, name] : kFiles) {
    const fs::path file = fs::path(folder) / name;
    if (!fs::is_regular_file(file)) {
      throw std::runtime_error("Dds.security: there is no file " + file.string());
    }
    dds_qset_prop(qos, property, ("file:" + fs::absolute(file).string()).c_str());
  }
}

}  // namespace vir::dds
