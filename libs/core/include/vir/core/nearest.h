#pragma once
/// What somebody meant who wrote a word that there is not.
#include <string>
#include <vector>

namespace vir {
inline namespace core {

/// The candidate closest to `word`, whatever the case, or empty if none is close: two letters may
/// differ, or a third of a long word.
std::string nearest(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace core
}  // namespace vir
