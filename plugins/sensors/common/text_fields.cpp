#include "text_fields.h"

#include <algorithm>
#include <filesystem>

#include "input_error.h"
#include "vir/core/text.h"

namespace vir {
namespace {

constexpr std::size_t kBuffer = 1 << 16;
/// A line longer than this is not a row of numbers: the rest is dropped, so that a binary file
/// given by mistake does not fill the memory.
constexpr std::size_t kMaxLine = 8192;

constexpr std::string_view kBlank = " \t\r";

}  // namespace

LineReader::LineReader(const std::string& path) : path_(path) {
  namespace fs = std::filesystem;
  std::error_code ec;
  if (!fs::is_regular_file(path, ec)) throw InputError(path + ": no such file");
  size_ = fs::file_size(path, ec);
  buffer_.resize(std::clamp<std::uint64_t>(size_, 1, kBuffer));
  file_.emplace(path);
  // Of UTF-16 about every other byte is left.
  if (file_->isUtf16()) size_ /= 2;
  if (!*file_) throw InputError(path + ": cannot be opened for reading (permissions?)");
}

bool LineReader::fill() {
  file_->read(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  filled_ = static_cast<std::size_t>(file_->gcount());
  at_ = 0;
  if (file_->bad()) failed_ = true;
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
    const std::string_view data = trimmed(*line, kBlank);
    if (data.empty() || data.front() == '#' || data.front() == '%') continue;
    *line = std::string(data);
    return true;
  }
  return false;
}

std::string LineReader::where() const { return path_ + ":" + std::to_string(line_number_); }

double LineReader::progress() const {
  if (size_ == 0) return 1;
  return std::min(1.0, static_cast<double>(consumed_) / static_cast<double>(size_));
}

void splitFields(std::string_view line, std::vector<std::string_view>* fields) {
  if (line.find(',') == std::string_view::npos) {
    splitWords(line, kBlank, fields);
    return;
  }
  fields->clear();
  for (;;) {
    const std::size_t comma = line.find(',');
    fields->push_back(trimmed(line.substr(0, comma), kBlank));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace vir
