#pragma once
/// What the loader needs to know of the registries beyond their public face.
#include <string>
#include <vector>

namespace vir::roles::registry {

/// Registrations from now on are credited to this file (empty: linked in).
void setCurrentPlugin(const std::string& file);
/// Clashes since the last call.
std::vector<std::string> takeProblems();
/// Number of names registered so far.
std::size_t size();

}  // namespace vir::roles::registry
