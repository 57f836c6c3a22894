#pragma once
/// Loading of plugins (shared objects). A loaded plugin is never unloaded: objects of its classes
/// may outlive any scope we could tie it to.
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace vir::roles {

/// A plugin cannot be found, loaded or named; the text says what is available.
class PluginError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Loads one plugin; does nothing if it is loaded already. Throws PluginError: missing file, not a
/// shared object or an undefined symbol (with the dynamic linker's words), a class or alias that
/// something else registered before, or nothing registered at all.
void loadPlugin(const std::string& file);

/// What a plugin may register.
enum class PluginRole { estimator, rendezvous, sensor };
using PluginRoles = std::set<PluginRole>;
inline const PluginRoles kAllPluginRoles{PluginRole::estimator, PluginRole::rendezvous,
                                         PluginRole::sensor};

/// The roles of which a plugin calls the registering function, as its dynamic symbols tell: it is
/// read, not loaded. All if they do not tell: no shared object, or one that leaves the registering
/// to another library.
PluginRoles rolesOfPlugin(const std::string& file);

/// Loads every `*.so` of a folder that registers something of `roles`, in name order; returns these
/// files. Throws PluginError if the folder is missing or a plugin fails.
std::vector<std::string> loadPluginFolder(const std::string& folder,
                                          const PluginRoles& roles = kAllPluginRoles);

/// `<folder of the executable>/../lib/vir-slam/plugins`: right in the build tree and where it is
/// installed.
std::string defaultPluginFolder();

}  // namespace vir::roles
