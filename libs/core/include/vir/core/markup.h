#pragma once
/// Text inside HTML and SVG.
#include <string>

namespace vir {
inline namespace core {

/// `text` with the characters that mean something in markup replaced, fit for element contents and
/// quoted attributes; control characters become spaces.
std::string escapedMarkup(const std::string& text);

}  // namespace core
}  // namespace vir
