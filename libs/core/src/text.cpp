#include "vir/core/text.h"

#include <algorithm>

namespace vir {
inline namespace core {

std::string lowerCase(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

std::string_view trimmed(std::string_view text, std::string_view blanks) {
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == text.npos) return text.substr(0, 0);
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

void splitWords(std::string_view text, std::string_view blanks,
                std::vector<std::string_view>* words) {
  words->clear();
  for (text = trimmed(text, blanks); !text.empty(); text = trimmed(text, blanks)) {
    const std::size_t end = std::min(text.find_first_of(blanks), text.size());
    words->push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
}

}  // namespace core
}  // namespace vir
