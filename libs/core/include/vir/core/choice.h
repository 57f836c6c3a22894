#pragma once
/// A setting that is a word in the file and an enum in the program.
#include <string>
#include <vector>

#include "vir/core/options.h"

namespace vir {
inline namespace core {

/// Declares `e` as one of `words`: the enum's values from 0, in their order. A value that has no
/// word (a program's cast) is shown as its number, which a checking visitor refuses.
template <typename Enum>
void chooseEnum(OptionVisitor& v, const char* key, Enum& e, const std::vector<std::string>& words,
                const char* doc) {
  const auto index = static_cast<std::size_t>(e);
  std::string word = index < words.size() ? words[index] : std::to_string(index);
  v.choice(key, word, words, doc);
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (word == words[i]) e = static_cast<Enum>(i);
  }
}

}  // namespace core
}  // namespace vir
