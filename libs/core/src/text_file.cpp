#include "vir/core/text_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "vir/core/text_stream.h"

namespace vir {
inline namespace core {
namespace fs = std::filesystem;

bool readLine(std::istream& in, std::string* line) {
  line->clear();
  const std::istream::sentry ready(in, true);
  if (!ready) return false;
  using Traits = std::istream::traits_type;
  std::streambuf& buffer = *in.rdbuf();
  bool any = false;
  for (;;) {
    const auto c = buffer.sbumpc();
    if (Traits::eq_int_type(c, Traits::eof())) {
      in.setstate(any ? std::ios::eofbit : std::ios::eofbit | std::ios::failbit);
      return any;
    }
    any = true;
    if (c == '\n') return true;
    if (line->size() < kLongestLine) line->push_back(Traits::to_char_type(c));
  }
}

std::string notAFile(const std::string& path) {
  std::error_code error;
  switch (fs::status(path, error).type()) {
    case fs::file_type::directory:
      return "a folder";
    case fs::file_type::character:
    case fs::file_type::block:
      return "a device";
    case fs::file_type::socket:
      return "a socket";
    default:
      return {};
  }
}

std::string whyNoText(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return {};
  TextStream in(path);
  if (in && in.get() == TextStream::traits_type::eof()) return "is empty";
  return {};
}

std::string readTextFile(const std::string& path, std::size_t most) {
  std::error_code error;
  if (!fs::exists(path, error)) throw std::runtime_error("there is no such file");
  const std::string other = notAFile(path);
  if (!other.empty()) throw std::runtime_error("this is " + other + ", not a file");
  errno = 0;
  TextStream in(path);
  const int reason = errno;
  std::string text, block(std::min<std::size_t>(most + 1, 1 << 16), '\0');
  while (in && text.size() <= most) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    text.append(block, 0, static_cast<std::size_t>(in.gcount()));
  }
  if (text.size() > most) {
    throw std::runtime_error("it is larger than " + std::to_string(most / 1000) +
                             " kB, which no such file is");
  }
  if (!in.eof() || in.bad()) {
    throw std::runtime_error(reason != 0 ? std::strerror(reason) : "it cannot be read");
  }
  return text;
}

}  // namespace core
}  // namespace vir
