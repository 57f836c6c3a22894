#include "line_assembler.h"

namespace vir {

void LineAssembler::feed(const std::uint8_t* bytes, std::size_t size, std::vector<Line>* lines) {
  for (std::size_t i = 0; i < size; ++i) {
    const char c = static_cast<char>(bytes[i]);
    if (c == '\r' || c == '\n') {
      if (!text_.empty()) lines->push_back({text_, first_, too_long_});
      text_.clear();
      first_ = too_long_ = false;
    } else if (text_.size() < longest_) {
      text_ += c;
    } else {
      too_long_ = true;
    }
  }
}

void LineAssembler::reset() {
  text_.clear();
  first_ = true;
  too_long_ = false;
}

}  // namespace vir
