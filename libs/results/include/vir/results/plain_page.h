#pragma once
#include <string>

#include "vir/core/time.h"

namespace vir::results {

/// A page without network or script in the style of the reports. `title` is escaped here, `content`
/// is markup; `command` (may be empty) made it.
std::string plainPage(const std::string& title, const std::string& content,
                      const std::string& command = {});

/// "2026-11-30 14:00:00 UTC" of a Unix time.
std::string dateText(TimeNs t);

}  // namespace vir::results
