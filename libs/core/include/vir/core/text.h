#pragma once
/// Small things about text, the same with every locale.
#include <string>
#include <string_view>
#include <vector>

namespace vir {
inline namespace core {

inline constexpr std::string_view kBlanks = " \t\r\n\v\f";

/// A to Z become a to z.
std::string lowerCase(std::string text);

/// Without blanks before and behind.
std::string_view trimmed(std::string_view text, std::string_view blanks = kBlanks);

/// What stands between blanks, from the first to the last; none is empty.
void splitWords(std::string_view text, std::string_view blanks,
                std::vector<std::string_view>* words);
inline std::vector<std::string_view> wordsOf(std::string_view text,
                                             std::string_view blanks = kBlanks) {
  std::vector<std::string_view> words;
  splitWords(text, blanks, &words);
  return words;
}

}  // namespace core
}  // namespace vir
