#include "gz_archive.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <stdexcept>

namespace vir {
namespace {

constexpr unsigned kBufferBytes = 256 * 1024;

std::string reasonOf(gzFile file) {
  int code = Z_OK;
  const char* text = gzerror(file, &code);
  if (code == Z_ERRNO) return std::strerror(errno);
  return text != nullptr && *text != '\0' ? text : "unknown error";
}

gzFile openOrThrow(const std::string& path, const char* mode, const char* what) {
  errno = 0;
  gzFile file = gzopen(path.c_str(), mode);
  if (file == nullptr) {
    throw std::runtime_error(std::string("cannot ") + what + " " + path + ": " +
                             (errno != 0 ? std::strerror(errno) : "out of memory"));
  }
  gzbuffer(file, kBufferBytes);
  return file;
}

}  // namespace

std::unique_ptr<GzArchive> GzArchive::forReading(const std::string& path) {
  return std::unique_ptr<GzArchive>(new GzArchive(openOrThrow(path, "rb", "open"), path));
}

std::unique_ptr<GzArchive> GzArchive::forWriting(const std::string& path, int level) {
  const std::string mode = "wb" + std::to_string(std::clamp(level, 0, 9));
  return std::unique_ptr<GzArchive>(new GzArchive(openOrThrow(path, mode.c_str(), "write"), path));
}

GzArchive::~GzArchive() {
  if (file_ != nullptr) gzclose(file_);
}

void GzArchive::close() {
  if (file_ == nullptr) return;
  errno = 0;
  const int code = gzclose(file_);
  file_ = nullptr;
  if (code == Z_OK) return;
  throw std::runtime_error("cannot finish writing " + path_ + ": " +
                           (code == Z_ERRNO ? std::strerror(errno) : zError(code)));
}

std::string GzArchive::streamError() const {
  int code = Z_OK;
  gzerror(file_, &code);
  if (code == Z_OK || code == Z_STREAM_END) return {};
  if (code == Z_BUF_ERROR) return "the compressed stream ends early";
  return reasonOf(file_);
}

std::int64_t GzArchive::compressedPosition() const { return gzoffset(file_); }

std::size_t GzArchive::write(const void* buf, std::size_t len) {
  const char* data = static_cast<const char*>(buf);
  std::size_t done = 0;
  while (done < len) {
    const auto chunk = static_cast<unsigned>(std::min<std::size_t>(len - done, 1u << 30));
    const int n = gzwrite(file_, data + done, chunk);
    if (n <= 0) throw std::runtime_error("cannot write " + path_ + ": " + reasonOf(file_));
    done += static_cast<std::size_t>(n);
  }
  return done;
}

std::size_t GzArchive::read(void* buf, std::size_t len) {
  char* data = static_cast<char*>(buf);
  std::size_t done = 0;
  while (done < len) {
    const auto chunk = static_cast<unsigned>(std::min<std::size_t>(len - done, 1u << 30));
    const int n = gzread(file_, data + done, chunk);
    if (n < 0) throw std::runtime_error("cannot read " + path_ + ": " + reasonOf(file_));
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  // MRPT's contract: nothing read at all is an error; it becomes CExceptionEOF between objects.
  if (done == 0 && len > 0) throw std::runtime_error("end of " + path_);
  return done;
}

}  // namespace vir
