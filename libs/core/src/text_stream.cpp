#include "vir/core/text_stream.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace vir {
inline namespace core {
namespace {

void appendUtf8(std::uint32_t c, std::string* out) {
  const auto put = [&](std::uint32_t byte) { out->push_back(static_cast<char>(byte)); };
  if (c < 0x80) {
    put(c);
  } else if (c < 0x800) {
    put(0xC0 | c >> 6);
    put(0x80 | (c & 0x3F));
  } else if (c < 0x10000) {
    put(0xE0 | c >> 12);
    put(0x80 | (c >> 6 & 0x3F));
    put(0x80 | (c & 0x3F));
  } else {
    put(0xF0 | c >> 18);
    put(0x80 | (c >> 12 & 0x3F));
    put(0x80 | (c >> 6 & 0x3F));
    put(0x80 | (c & 0x3F));
  }
}

constexpr std::uint32_t kReplacement = 0xFFFD;

enum class Order { none, little, big };

bool isPlain(char c) { return c == '\t' || c == '\n' || c == '\r' || (c >= 0x20 && c < 0x7F); }

Order orderOf(const std::array<char, 4>& b, std::streamsize n) {
  if (n >= 2 && b[0] == '\xFF' && b[1] == '\xFE') return Order::little;
  if (n >= 2 && b[0] == '\xFE' && b[1] == '\xFF') return Order::big;
  if (n < 4) return Order::none;
  if (isPlain(b[0]) && b[1] == 0 && isPlain(b[2]) && b[3] == 0) return Order::little;
  if (isPlain(b[1]) && b[0] == 0 && isPlain(b[3]) && b[2] == 0) return Order::big;
  return Order::none;
}

}  // namespace

class TextStream::Utf16Buffer final : public std::streambuf {
 public:
  Utf16Buffer(std::filebuf* file, bool little) : file_(file), little_(little) {}

 protected:
  int_type underflow() override {
    text_.clear();
    while (text_.empty()) {
      const std::streamsize n = file_->sgetn(raw_.data(), raw_.size());
      if (n <= 0) {
        if (high_ == 0) return traits_type::eof();
        appendUtf8(kReplacement, &text_);
        high_ = 0;
        break;
      }
      for (std::streamsize i = 0; i + 1 < n; i += 2) take(unitAt(i));
      if (n % 2 != 0) appendUtf8(kReplacement, &text_);
    }
    setg(text_.data(), text_.data(), text_.data() + text_.size());
    return traits_type::to_int_type(text_[0]);
  }
  pos_type seekoff(off_type by, std::ios::seekdir from, std::ios::openmode which) override {
    return cleared(file_->pubseekoff(by, from, which), which);
  }
  pos_type seekpos(pos_type at, std::ios::openmode which) override {
    return cleared(file_->pubseekpos(at, which), which);
  }

 private:
  /// What was decoded is forgotten, and reading goes on with a whole character.
  pos_type cleared(pos_type at, std::ios::openmode which) {
    high_ = 0;
    setg(nullptr, nullptr, nullptr);
    if (at != pos_type(off_type(-1)) && at % 2 != 0)
      at = file_->pubseekpos(at - off_type(1), which);
    return at;
  }
  std::uint32_t unitAt(std::streamsize i) const {
    const auto a = static_cast<unsigned char>(raw_[static_cast<std::size_t>(i)]);
    const auto b = static_cast<unsigned char>(raw_[static_cast<std::size_t>(i) + 1]);
    return little_ ? std::uint32_t{a} | std::uint32_t{b} << 8
                   : std::uint32_t{b} | std::uint32_t{a} << 8;
  }
  void take(std::uint32_t unit) {
    const bool low = unit >= 0xDC00 && unit < 0xE000;
    if (high_ != 0) {
      appendUtf8(low ? 0x10000 + ((high_ - 0xD800) << 10) + (unit - 0xDC00) : kReplacement, &text_);
      high_ = 0;
      if (low) return;
    } else if (low) {
      unit = kReplacement;
    }
    if (unit >= 0xD800 && unit < 0xDC00) {
      high_ = unit;
    } else if (unit != 0xFEFF) {
      appendUtf8(unit, &text_);
    }
  }

  std::filebuf* file_;
  bool little_;
  std::uint32_t high_ = 0;  ///< first half of a pair that waits for the second; 0: none
  std::array<char, 1 << 15> raw_{};
  std::string text_;
};

TextStream::TextStream(const std::string& path) : std::istream(nullptr) {
  if (file_.open(path, std::ios::in | std::ios::binary) == nullptr) {
    setstate(std::ios::failbit);
    return;
  }
  std::array<char, 4> begin{};
  Order order = Order::none;
  // A pipe cannot go back; what comes from one is taken as it is.
  if (file_.pubseekoff(0, std::ios::cur, std::ios::in) != std::streampos(-1)) {
    // Of a folder the buffer itself throws, a stream does not.
    std::istream raw(&file_);
    raw.read(begin.data(), begin.size());
    order = orderOf(begin, raw.gcount());
    file_.pubseekpos(0, std::ios::in);
  }
  if (order != Order::none) {
    utf16_ = std::make_unique<Utf16Buffer>(&file_, order == Order::little);
    rdbuf(utf16_.get());
  } else {
    rdbuf(&file_);
  }
}

TextStream::~TextStream() = default;

}  // namespace core
}  // namespace vir
