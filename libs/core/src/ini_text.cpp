#include "ini_text.h"

#include <mrpt/config/config_parser.h>

#include <algorithm>
#include <cctype>
#include <regex>
#include <sstream>

#include "vir/core/ini_writer.h"
#include "vir/core/parse_number.h"
#include "vir/core/text.h"

namespace vir::ini {
namespace {

bool startsComment(const std::string& text, std::size_t at) {
  return text[at] == ';' || text[at] == '#' || text.compare(at, 2, "//") == 0;
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

bool isContinued(const std::string& line) {
  // MRPT ends a @define at the line's end, whatever stands there.
  if (line.find("@define") != std::string::npos) return false;
  const std::size_t n = line.size();
  if (n > 0 && line[n - 1] == '\\') return true;
  return n > 1 && line[n - 1] == '\r' && line[n - 2] == '\\';
}

/// The first line of an MRPT message says it all; the rest is a stack trace.
std::string shortReason(const std::exception& e, int* line) {
  std::string text = e.what();
  const std::size_t message = text.find("Message:");
  if (message != std::string::npos) text = text.substr(message + 8);
  text = trim(text.substr(0, text.find('\n', text.find_first_not_of(kBlanks))));
  std::smatch match;
  if (std::regex_search(text, match, std::regex("Line ([0-9]{1,8}):"))) {
    parseNumber(match[1].str(), line);
  }
  return text;
}

template <typename T, typename Text>
std::string rangeText(const std::string& kind, Bounds<T> bounds, Text text) {
  const bool low = bounds.min > std::numeric_limits<T>::lowest();
  const bool high = bounds.max < std::numeric_limits<T>::max();
  if (low && high) return kind + " from " + text(bounds.min) + " to " + text(bounds.max);
  if (low) return kind + ", at least " + text(bounds.min);
  if (high) return kind + ", at most " + text(bounds.max);
  return kind;
}

}  // namespace

std::string trim(const std::string& text) { return std::string(trimmed(text)); }

std::string withoutComment(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool after_blank = i == 0 || text[i - 1] == ' ' || text[i - 1] == '\t';
    if (after_blank && startsComment(text, i)) return trim(text.substr(0, i));
  }
  return trim(text);
}

std::string shown(const std::string& text) {
  std::string out = text.substr(0, 80);
  for (char& c : out) {
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = '?';
  }
  return text.size() > out.size() ? out + "..." : out;
}

std::string joined(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : ", ") + word;
  return out;
}

std::string allowedText(Bounds<int> bounds) {
  return rangeText("a whole number", bounds, [](int v) { return std::to_string(v); });
}

std::string allowedText(Bounds<double> bounds) {
  return rangeText("a number", bounds, [](double v) { return numberText(v); });
}

std::string allowedListText(std::size_t size) {
  return (size == 0 ? "numbers" : std::to_string(size) + " numbers") +
         std::string(" with blanks between");
}

std::vector<Line> expandedLines(const std::string& text, const std::string& name) {
  static const std::string kByteOrderMark = "\xEF\xBB\xBF";
  const bool marked = text.compare(0, kByteOrderMark.size(), kByteOrderMark) == 0;
  std::vector<std::string> raw = split(marked ? text.substr(kByteOrderMark.size()) : text);
  // MRPT expands inside comments too, where a `${...}` that only explains would be an error.
  std::string input;
  std::vector<int> starts;
  bool continued = false;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (!continued) starts.push_back(static_cast<int>(i) + 1);
    const std::size_t first = raw[i].find_first_not_of(kBlanks);
    if (!continued && first != std::string::npos && startsComment(raw[i], first)) raw[i].clear();
    continued = isContinued(raw[i]);
    input += raw[i] + '\n';
  }
  std::string expanded;
  try {
    expanded = mrpt::config::config_parser(input);
  } catch (const std::exception& e) {
    int line = 0;
    const std::string reason = shortReason(e, &line);
    throw SettingsError({name, line}, "", "", reason);
  }
  std::vector<Line> lines;
  for (const std::string& line : split(expanded)) {
    const std::size_t i = std::min(lines.size(), starts.size() - 1);
    lines.push_back({starts[i], line});
  }
  return lines;
}

}  // namespace vir::ini
