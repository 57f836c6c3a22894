#pragma once
/// Text in UTF-16, as some programs for Windows save it.
#include <string>

namespace vir::test {

/// `text`: of ASCII characters alone.
inline std::string utf16(const std::string& text, bool little = true, bool mark = true) {
  std::string out;
  if (mark) out = little ? "\xFF\xFE" : "\xFE\xFF";
  for (const char c : text) {
    if (!little) out += '\0';
    out += c;
    if (little) out += '\0';
  }
  return out;
}

}  // namespace vir::test
