#pragma once
/// Lines out of bytes that come in pieces, with bounded memory.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vir {

class LineAssembler {
 public:
  explicit LineAssembler(std::size_t longest) : longest_(longest) {}

  struct Line {
    std::string text;       ///< without its end; never empty
    bool fragment = false;  ///< the first after reset(): its beginning may be missing
    bool too_long = false;  ///< only the beginning is here
  };

  /// Adds the lines that these bytes end (by \r or \n).
  void feed(const std::uint8_t* bytes, std::size_t size, std::vector<Line>* lines);
  /// Forgets the line begun.
  void reset();
  /// Bytes held.
  std::size_t buffered() const { return text_.size(); }
  /// The line begun, e.g. a prompt.
  std::string_view begun() const { return text_; }

 private:
  std::size_t longest_;
  std::string text_;
  bool first_ = true, too_long_ = false;
};

}  // namespace vir
