#pragma once
/// Text files that may be in UTF-16, as some programs for Windows save them.
#include <fstream>
#include <istream>
#include <memory>
#include <streambuf>
#include <string>

namespace vir {
inline namespace core {

/// A text file to read from, in UTF-8 whether it is that or UTF-16 (by its byte-order mark, or by
/// every other byte of its beginning being 0). Positions are bytes of the file. A failed stream
/// where it cannot be opened. A half character at the end, or half a pair, becomes U+FFFD.
class TextStream : public std::istream {
 public:
  explicit TextStream(const std::string& path);
  ~TextStream() override;
  bool isUtf16() const { return utf16_ != nullptr; }

 private:
  class Utf16Buffer;
  std::filebuf file_;
  std::unique_ptr<Utf16Buffer> utf16_;
};

}  // namespace core
}  // namespace vir
