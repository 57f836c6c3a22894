#pragma once
#include <string>

namespace vir::results {

/// A page without network or script in the style of the reports. `title` is escaped here, `content`
/// is markup.
std::string plainPage(const std::string& title, const std::string& content);

}  // namespace vir::results
