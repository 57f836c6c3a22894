#include "vir/tables/layout.h"

#include <algorithm>
#include <cctype>
#include <fstream>

#include "vir/core/text.h"

namespace vir::tables {
namespace {

constexpr std::size_t kSampledBytes = 64 << 10;

constexpr std::string_view kBlank = " \t\r\"";

std::string_view trim(std::string_view s) { return trimmed(s, kBlank); }

bool isDigit(char c) { return c >= '0' && c <= '9'; }

/// A number, or what stands for one that is missing.
bool beginsAsData(std::string_view line) {
  line = trim(line);
  if (line.empty()) return false;
  const char c = line.front();
  return isDigit(c) || c == '-' || c == '+' || c == '.';
}

/// The rest of a comment, without its mark.
std::string_view commentOf(std::string_view line) {
  line.remove_prefix(std::min(line.find_first_not_of(" \t\r\"#%"), line.size()));
  return line;
}

std::string unitOf(std::string_view name) {
  const std::size_t open = name.find_first_of("[(");
  if (open == std::string_view::npos) return {};
  const std::size_t close = name.find_first_of("])", open);
  return std::string(trim(name.substr(open + 1, close == name.npos ? close : close - open - 1)));
}

}  // namespace

void splitLine(std::string_view line, char separator, std::vector<std::string_view>* fields) {
  if (separator == ' ') {
    splitWords(line, kBlank, fields);
    return;
  }
  fields->clear();
  for (;;) {
    const std::size_t end = line.find(separator);
    fields->push_back(trim(line.substr(0, end)));
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
  }
}

char separatorOf(std::string_view line) {
  for (const char c : {';', ',', '\t'}) {
    if (line.find(c) != std::string_view::npos) return c;
  }
  return ' ';
}

std::string plainName(std::string_view name) {
  const std::size_t open = name.find_first_of("[(");
  const bool place = open != name.npos && open + 2 < name.size() && isDigit(name[open + 1]) &&
                     (name[open + 2] == ']' || name[open + 2] == ')');
  const std::string last = place ? std::string("_") + name[open + 1] : "";
  name = trim(name.substr(0, open));
  std::string out;
  for (const char c : name) {
    const auto u = static_cast<unsigned char>(c);
    out += std::isalnum(u) != 0 ? static_cast<char>(std::tolower(u)) : '_';
  }
  out += last;
  return out;
}

int Layout::find(const std::vector<std::string>& wanted) const {
  for (const std::string& w : wanted) {
    const auto it = std::find(names.begin(), names.end(), w);
    if (it != names.end()) return static_cast<int>(it - names.begin());
  }
  return -1;
}

std::vector<std::string> Layout::column(std::size_t index) const {
  std::vector<std::string> out;
  for (const auto& row : rows) {
    if (index < row.size()) out.push_back(row[index]);
  }
  return out;
}

Layout layoutOfText(std::string_view text) {
  Layout layout;
  std::string header;
  std::vector<std::string_view> fields;
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  while (!text.empty() && layout.rows.size() < Layout::kSampled) {
    const std::size_t end = text.find('\n');
    const std::string_view line = trim(text.substr(0, end));
    text.remove_prefix(end == text.npos ? text.size() : end + 1);
    if (line.empty()) continue;
    const bool comment = line.front() == '#' || line.front() == '%';
    if (comment || (layout.rows.empty() && header.empty() && !beginsAsData(line))) {
      if (layout.rows.empty()) header = std::string(comment ? commentOf(line) : line);
      continue;
    }
    if (layout.rows.empty()) layout.separator = separatorOf(line);
    splitLine(line, layout.separator, &fields);
    layout.columns = std::max(layout.columns, fields.size());
    layout.rows.emplace_back(fields.begin(), fields.end());
  }
  if (header.empty()) return layout;
  char separator = separatorOf(header);
  if (layout.rows.empty()) layout.separator = separator;
  splitLine(header, separator, &fields);
  for (const std::string_view name : fields) {
    layout.names.push_back(plainName(name));
    layout.units.push_back(unitOf(name));
  }
  return layout;
}

Layout layoutOf(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text(kSampledBytes, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  // The last line may be cut.
  if (text.size() == kSampledBytes) text.resize(text.rfind('\n') + 1);
  return layoutOfText(text);
}

}  // namespace vir::tables
