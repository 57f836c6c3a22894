#pragma once
/// What somebody wants of a recording: `ROLE=NAME`, with blanks between.
#include <string>
#include <vector>

#include "vir/core/text.h"

namespace vir {

/// One after the other. Names may have blanks: a word that does not begin with a role and `=` goes
/// on with the name before it. `is_role`: whether a text is one.
template <typename IsRole>
std::vector<std::string> splitWishes(const std::string& text, const IsRole& is_role) {
  std::vector<std::string> out;
  for (const std::string_view word : wordsOf(text)) {
    const std::size_t at = word.find('=');
    const bool begins = at != word.npos && is_role(std::string(word.substr(0, at)));
    if (begins || out.empty()) {
      out.emplace_back(word);
    } else {
      out.back() += ' ';
      out.back() += word;
    }
  }
  return out;
}

}  // namespace vir
