#pragma once
#include <string>

namespace vir::app {

/// The ini that `import` left beside a rawlog (`x.rawlog` -> `x.ini`), or empty. A file of that
/// name which somebody else wrote is none of our business.
std::string companionOf(const std::string& rawlog);

}  // namespace vir::app
