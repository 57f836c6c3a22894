#include "text_fields.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <limits>

#include "input_error.h"

namespace vir {
namespace {

constexpr std::size_t kBuffer = 1 << 16;
/// A line longer than this is not a row of numbers: the rest is dropped, so that a binary file
/// given by mistake does not fill the memory.
constexpr std::size_t kMaxLine = 8192;

bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::string_view trim(std::string_view s) {
  while (!s.empty() && isBlank(s.front())) s.remove_prefix(1);
  while (!s.empty() && isBlank(s.back())) s.remove_suffix(1);
  return s;
}

}  // namespace

LineReader::LineReader(const std::string& path) : path_(path), buffer_(kBuffer) {
  namespace fs = std::filesystem;
  std::error_code ec;
  if (!fs::is_regular_file(path, ec)) throw InputError(path + ": no such file");
  size_ = fs::file_size(path, ec);
  file_.open(path, std::ios::binary);
  if (!file_) throw InputError(path + ": cannot be opened for reading (permissions?)");
}

bool LineReader::fill() {
  file_.read(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  filled_ = static_cast<std::size_t>(file_.gcount());
  at_ = 0;
  if (file_.bad()) failed_ = true;
  return filled_ > 0;
}

bool LineReader::rawLine(std::string* line) {
  line->clear();
  bool any = false;
  for (;;) {
    if (at_ == filled_ && !fill()) {
      if (!any) return false;
      open_end_ = true;
      ++line_number_;
      return true;
    }
    any = true;
    const char* begin = buffer_.data() + at_;
    const char* end = buffer_.data() + filled_;
    const char* stop = std::find(begin, end, '\n');
    const auto take = static_cast<std::size_t>(stop - begin);
    line->append(begin, std::min(take, kMaxLine - std::min(kMaxLine, line->size())));
    at_ += take;
    consumed_ += take;
    if (stop != end) {
      ++at_;
      ++consumed_;
      ++line_number_;
      open_end_ = false;
      return true;
    }
  }
}

bool LineReader::next(std::string* line) {
  while (rawLine(line)) {
    if (line_number_ == 1 && line->compare(0, 3, "\xEF\xBB\xBF") == 0) line->erase(0, 3);
    const std::string_view data = trim(*line);
    if (data.empty() || data.front() == '#' || data.front() == '%') continue;
    *line = std::string(data);
    return true;
  }
  return false;
}

std::string LineReader::where() const { return path_ + ":" + std::to_string(line_number_); }

double LineReader::progress() const {
  return size_ == 0 ? 1.0 : static_cast<double>(consumed_) / static_cast<double>(size_);
}

void splitFields(std::string_view line, std::vector<std::string_view>* fields) {
  fields->clear();
  if (line.find(',') != std::string_view::npos) {
    for (;;) {
      const std::size_t comma = line.find(',');
      fields->push_back(trim(line.substr(0, comma)));
      if (comma == std::string_view::npos) return;
      line.remove_prefix(comma + 1);
    }
  }
  for (line = trim(line); !line.empty(); line = trim(line)) {
    const std::size_t end =
        static_cast<std::size_t>(std::find_if(line.begin(), line.end(), isBlank) - line.begin());
    fields->push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

bool parseNumber(std::string_view field, double* value) {
  if (!field.empty() && field.front() == '+') field.remove_prefix(1);
  if (field.empty()) return false;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), *value);
  if (end != field.data() + field.size()) return false;
  // 1e-400 is reported as out of range: too small to matter. 1e400 is as good as infinite.
  if (error == std::errc::result_out_of_range) {
    const bool tiny = field.find("e-") != field.npos || field.find("E-") != field.npos;
    *value = tiny ? 0.0 : std::numeric_limits<double>::infinity();
    return true;
  }
  return error == std::errc();
}

bool parseNs(std::string_view field, TimeNs* t) {
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), *t);
  return error == std::errc() && end == field.data() + field.size() && *t >= 0;
}

bool parseDecimalSeconds(std::string_view field, TimeNs* t) {
  constexpr int kDigits = 9;
  const std::size_t dot = field.find('.');
  const std::string_view whole = field.substr(0, dot);
  const std::string_view part = dot == field.npos ? std::string_view() : field.substr(dot + 1);
  TimeNs seconds = 0;
  if (!parseNs(whole, &seconds)) return false;
  if (seconds > std::numeric_limits<TimeNs>::max() / 1000000000 - 1) return false;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (!std::all_of(part.begin(), part.end(), is_digit)) return false;
  TimeNs ns = 0;
  for (int i = 0; i < kDigits; ++i) {
    const auto k = static_cast<std::size_t>(i);
    ns = ns * 10 + (k < part.size() ? part[k] - '0' : 0);
  }
  if (part.size() > kDigits && part[kDigits] >= '5') ++ns;
  *t = seconds * 1000000000 + ns;
  return true;
}

}  // namespace vir
