#include "csv_text.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace vir::results::csv {

std::string format(const char* pattern, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

double clean(double v) { return std::isfinite(v) ? v : 0; }

std::string csvNumber(double v) { return std::isfinite(v) ? format("%.9g", v) : std::string(); }

std::string csvWord(std::string text) {
  for (char& c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == ',' || c == '"' || byte < 0x20 || byte == 0x7f) c = ';';
  }
  return text;
}

}  // namespace vir::results::csv
