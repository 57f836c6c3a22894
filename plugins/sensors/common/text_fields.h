#pragma once
/// Text files of numbers, read line by line: comments, blank lines, CRLF and a byte-order mark are
/// dealt with here.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "vir/core/parse_number.h"
#include "vir/core/text_stream.h"
#include "vir/core/time.h"

namespace vir {

class LineReader {
 public:
  /// Throws InputError when the file cannot be opened.
  explicit LineReader(const std::string& path);

  /// The next line that holds data, without its line break. False at the end of the file.
  bool next(std::string* line);
  /// 1-based number of the line last returned.
  long lineNumber() const { return line_number_; }
  /// "path:line" of the line last returned.
  std::string where() const;
  /// True when the line last returned ended with the file, not with a line break: it may be cut.
  bool lastLineOpen() const { return open_end_; }
  /// True when reading stopped at an error of the device, not at the end of the file.
  bool failed() const { return failed_; }
  /// Share of the file read so far, 0..1.
  double progress() const;
  const std::string& path() const { return path_; }

 private:
  bool rawLine(std::string* line);
  bool fill();

  std::string path_;
  std::optional<TextStream> file_;
  std::vector<char> buffer_;
  std::size_t at_ = 0, filled_ = 0;
  std::uint64_t consumed_ = 0, size_ = 0;
  long line_number_ = 0;
  bool open_end_ = false, failed_ = false;
};

/// Splits at commas, or at blanks where there is no comma; fields come without surrounding blanks.
void splitFields(std::string_view line, std::vector<std::string_view>* fields);

}  // namespace vir
