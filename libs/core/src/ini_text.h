#pragma once
/// Pieces shared by reader and writer of ini text.
#include <string>
#include <vector>

#include "vir/core/options.h"
#include "vir/core/settings.h"

namespace vir::ini {

std::string trim(const std::string& text);
/// Cuts a comment (`//`, `;`, `#` at the start or after a blank) and trims.
std::string withoutComment(const std::string& text);
/// For messages: control characters replaced, cut at 80 characters.
std::string shown(const std::string& text);
std::string joined(const std::vector<std::string>& words);

/// What is allowed, in words.
std::string allowedText(Bounds<int> bounds);
std::string allowedText(Bounds<double> bounds);
std::string allowedListText(std::size_t size);

/// One line with what is left after variables are expanded and continued lines joined.
struct Line {
  int number = 0;  ///< where it starts in the file, 1-based
  std::string text;
};
/// Throws SettingsError if a variable or formula cannot be expanded.
std::vector<Line> expandedLines(const std::string& text, const std::string& name);

}  // namespace vir::ini
