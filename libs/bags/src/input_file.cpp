#include "input_file.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>

namespace vir::bags {
namespace {

constexpr std::size_t kBuffer = std::size_t{1} << 20;

}  // namespace

InputFile::InputFile(const std::string& path) : name_(path) {
  struct stat status {};
  file_.reset(std::fopen(path.c_str(), "rb"));
  if (!file_ || ::fstat(::fileno(file_.get()), &status) != 0 || !S_ISREG(status.st_mode)) {
    throw BagError(path + ": cannot be opened as a file: " + std::strerror(errno ? errno : EISDIR));
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
  std::setvbuf(file_.get(), nullptr, _IOFBF, kBuffer);
}

InputFile::InputFile(ByteView bytes, std::string name)
    : memory_(bytes), name_(std::move(name)), size_(bytes.size) {}

bool InputFile::read(void* out, std::size_t size) {
  if (size > left()) {
    position_ = size_;
    return false;
  }
  if (!file_) {
    if (size > 0) std::memcpy(out, memory_.data + position_, size);
  } else if (std::fread(out, 1, size, file_.get()) != size) {
    size_ = position_;  // the disk fails, or somebody cut the file meanwhile
    return false;
  }
  position_ += size;
  return true;
}

void InputFile::readUpTo(std::uint64_t size, Bytes* out) {
  out->resize(static_cast<std::size_t>(std::min(size, left())));
  if (!read(out->data(), out->size())) out->clear();
}

void InputFile::skip(std::uint64_t size) {
  size = std::min(size, left());
  if (file_ && ::fseeko(file_.get(), static_cast<off_t>(size), SEEK_CUR) != 0) size = left();
  position_ += size;
}

std::string InputFile::where() const { return name_ + ": at byte " + std::to_string(position_); }

}  // namespace vir::bags
