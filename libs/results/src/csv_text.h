#pragma once
/// Text of csv files: no NaN, no comma inside a word.
#include <Eigen/Core>
#include <string>

namespace vir::results::csv {

/// printf into a string of at most 255 characters.
__attribute__((format(printf, 1, 2))) std::string format(const char* pattern, ...);

/// 0 for what is not a number: no NaN may reach a file.
double clean(double v);

/// 9 significant digits; nothing for what is not a number.
std::string csvNumber(double v);

/// Without commas, quotes and control characters.
std::string csvWord(std::string text);

}  // namespace vir::results::csv
