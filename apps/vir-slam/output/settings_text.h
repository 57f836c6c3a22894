#pragma once
/// The settings of plugins as text. Plugins must be loaded.
#include <string>

namespace vir::app {

/// The settings of the estimator, rendezvous solver or sensor `name` with their defaults, as a
/// commented ini. Throws roles::PluginError if there is none.
std::string settingsText(const std::string& name);

/// A line `ROLE Section.key` for each setting there is: ROLE is estimator, rendezvous, simulator,
/// source (what `import` reads) or live (what `record` reads).
std::string settingsKeys();

}  // namespace vir::app
