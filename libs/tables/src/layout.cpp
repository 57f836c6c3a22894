#include "vir/tables/layout.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <system_error>

#include "units.h"
#include "vir/core/text.h"
#include "vir/core/text_stream.h"

namespace vir::tables {
namespace {

constexpr std::size_t kSampledBytes = 64 << 10, kLaterBytes = 2048;
constexpr std::size_t kLaterPlaces = 64;

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

/// Where the unit behind a name begins: at its bracket, or at the slash of `acc_x / mg` and
/// `t/ms`.
std::size_t unitStart(std::string_view name) {
  const std::size_t open = name.find_first_of("[({<");
  if (open != name.npos) return open;
  const std::size_t slash = name.find('/');
  if (slash == name.npos || slash == 0) return name.npos;
  const std::string_view behind = name.substr(slash + 1);
  if (unitOfText(behind).quantity == Quantity::none && !stampUnitOfText(behind)) return name.npos;
  // All of `deg/s` in `wx_deg/s` is the unit.
  const std::size_t word = name.find_last_of("_ ", slash);
  const bool longer =
      word != name.npos && unitOfText(name.substr(word + 1)).quantity != Quantity::none;
  return longer && trim(name.substr(word + 1, slash - word - 1)) != "" ? name.npos : slash;
}

std::string unitOf(std::string_view name) {
  const std::size_t open = unitStart(name);
  if (open == std::string_view::npos) return {};
  const std::size_t close = name.find_last_of("])}>");
  const bool closed = close != name.npos && close > open;
  return std::string(trim(name.substr(open + 1, closed ? close - open - 1 : close)));
}

/// `rostopic echo -p` writes `field.` in front of all names.
std::string_view withoutField(std::string_view name) {
  constexpr std::string_view kField = "field.";
  name = trim(name);
  if (name.size() > kField.size() && name.substr(0, kField.size()) == kField) {
    name.remove_prefix(kField.size());
  }
  return name;
}

}  // namespace

std::string plainName(std::string_view name) {
  name = withoutField(name);
  const std::size_t open = name.find_first_of("[(");
  const bool place = open != name.npos && open + 2 < name.size() && isDigit(name[open + 1]) &&
                     (name[open + 2] == ']' || name[open + 2] == ')');
  const std::string last = place ? std::string("_") + name[open + 1] : "";
  const std::string text = asciiUnits(trim(name.substr(0, unitStart(name))));
  std::string out;
  for (const char c : trimmed(text, " _/\t")) {
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

namespace {

/// Words of a header between blanks; a unit in brackets belongs to the word before it.
void splitHeader(std::string_view header, std::vector<std::string_view>* fields) {
  splitLine(header, ' ', fields);
  std::vector<std::string_view> out;
  for (const std::string_view word : *fields) {
    const bool open = !out.empty() && out.back().find_first_of("[(") != word.npos &&
                      out.back().find_first_of("])") == word.npos;
    const bool unit = word.front() == '[' || word.front() == '(';
    if (!out.empty() && (open || unit)) {
      const char* begin = out.back().data();
      out.back() = {begin, static_cast<std::size_t>(word.data() + word.size() - begin)};
    } else {
      out.push_back(word);
    }
  }
  *fields = std::move(out);
}

void readNames(std::string_view header, Layout* layout) {
  std::vector<std::string_view> fields;
  const char separator = layout->header_separator = separatorOf(header);
  if (layout->rows.empty()) layout->separator = separator;
  if (separator == ' ') {
    splitHeader(header, &fields);
  } else {
    splitLine(header, separator, &fields);
  }
  for (const std::string_view field : fields) {
    const std::string_view name = withoutField(field);
    layout->names.push_back(plainName(name));
    layout->units.push_back(unitOf(name));
    layout->written.emplace_back(trimmed(name.substr(0, unitStart(name)), " _/\t\r\""));
  }
  // The date's name goes with its column, where it has one.
  if (layout->date_apart >= 0 && layout->names.size() > layout->columns) {
    layout->names.erase(layout->names.begin() + layout->date_apart);
    layout->units.erase(layout->units.begin() + layout->date_apart);
    layout->written.erase(layout->written.begin() + layout->date_apart);
  }
  for (const std::string& name : layout->names) layout->bare.push_back(bareName(name));
}

/// Text that is no UTF-8 is Latin-1, or Windows' own kind of it.
std::string utf8Of(const std::string& text) {
  bool good = true;
  for (std::size_t i = 0; good && i < text.size();) {
    const auto c = static_cast<unsigned char>(text[i++]);
    int more = c < 0x80 ? 0 : c >= 0xC2 && c < 0xE0 ? 1 : c >= 0xE0 && c < 0xF0 ? 2 : 3;
    good = c < 0x80 || (c >= 0xC2 && c < 0xF5);
    for (; good && more > 0; --more, ++i) {
      good = i < text.size() && (static_cast<unsigned char>(text[i]) & 0xC0) == 0x80;
    }
  }
  if (good) return text;
  std::string out;
  for (const char letter : text) {
    const auto c = static_cast<unsigned char>(letter);
    if (c >= 0x80) out += static_cast<char>(0xC0 | (c >> 6));
    out += static_cast<char>(c < 0x80 ? c : 0x80 | (c & 0x3F));
  }
  return out;
}

bool isComment(std::string_view line) { return line.front() == '#' || line.front() == '%'; }

/// Rows of data from all over the text, evenly: of twice as many as are kept every second goes.
std::vector<std::string_view> linesAllOver(std::string_view text) {
  std::vector<std::string_view> kept;
  std::size_t step = 1;
  for (std::size_t i = 0; !text.empty(); ++i) {
    const std::size_t end = text.find('\n');
    const std::string_view line = trim(text.substr(0, end));
    text.remove_prefix(end == text.npos ? text.size() : end + 1);
    if (i % step != 0 || line.empty() || isComment(line)) continue;
    kept.push_back(line);
    if (kept.size() < 2 * kLaterPlaces) continue;
    for (std::size_t k = 0; k < kLaterPlaces; ++k) kept[k] = kept[2 * k];
    kept.resize(kLaterPlaces);
    step *= 2;
  }
  return kept;
}

}  // namespace

Layout layoutOfText(std::string_view text) {
  Layout layout;
  std::string header;
  std::vector<std::string> lines;
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  while (!text.empty() && lines.size() < Layout::kSampled) {
    const std::size_t end = text.find('\n');
    const std::string_view line = trim(text.substr(0, end));
    text.remove_prefix(end == text.npos ? text.size() : end + 1);
    if (line.empty()) continue;
    const bool comment = isComment(line);
    if (comment || (lines.empty() && header.empty() && !beginsAsData(line))) {
      if (lines.empty()) header = std::string(comment ? commentOf(line) : line);
      continue;
    }
    lines.emplace_back(line);
  }
  if (!lines.empty()) {
    static_cast<RowFormat&>(layout) = rowFormatOf(lines, separatorOf(lines.front()));
  }
  RowSplitter splitter(layout);
  std::vector<std::string_view> fields;
  for (const std::string& line : lines) {
    splitter.split(line, &fields);
    layout.columns = std::max(layout.columns, fields.size());
    layout.rows.emplace_back(fields.begin(), fields.end());
  }
  for (const std::string_view line : linesAllOver(text)) {
    splitter.split(line, &fields);
    layout.later.emplace_back(fields.begin(), fields.end());
  }
  if (!header.empty()) readNames(utf8Of(header), &layout);
  return layout;
}

Layout layoutOf(const std::string& path) {
  TextStream in(path);
  std::error_code ec;
  const std::uintmax_t whole = std::filesystem::file_size(path, ec);
  // What is no file of a known size is read all the same.
  std::string text(ec ? kSampledBytes : std::min<std::uintmax_t>(whole, kSampledBytes), '\0');
  const auto read = [&](std::string* into) {
    in.read(into->data(), static_cast<std::streamsize>(into->size()));
    into->resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  };
  read(&text);
  // The last line may be cut.
  const bool more = text.size() == kSampledBytes;
  if (more) text.resize(text.rfind('\n') + 1);
  Layout layout = layoutOfText(text);
  if (!more || layout.rows.empty() || !in.seekg(0, std::ios::end)) return layout;
  const auto size = static_cast<long long>(in.tellg());
  RowSplitter splitter(layout);
  std::vector<std::string_view> fields;
  for (std::size_t i = 1; i <= kLaterPlaces; ++i) {
    std::string piece(kLaterBytes, '\0');
    if (!in.seekg(std::max(0LL, size - static_cast<long long>(kLaterBytes)) /
                  static_cast<long long>(kLaterPlaces) * static_cast<long long>(i))) {
      break;
    }
    read(&piece);
    in.clear();
    // A whole line: neither the first nor the last is.
    const std::size_t begin = piece.find('\n'), end = piece.find('\n', begin + 1);
    if (begin == piece.npos || end == piece.npos) continue;
    const std::string_view line = trim(std::string_view(piece).substr(begin + 1, end - begin - 1));
    if (line.empty() || isComment(line)) continue;
    splitter.split(line, &fields);
    layout.later.emplace_back(fields.begin(), fields.end());
  }
  return layout;
}

}  // namespace vir::tables
