#include "gz_archive.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "more_classes.h"
#include "vir/rawlog/mrpt_error.h"

namespace vir::rawlog {
namespace {

constexpr unsigned kBufferBytes = 256 * 1024;
// A recording is handed over by whole objects: the buffer must not run full in between.
constexpr unsigned kRecordingBufferBytes = 16u << 20;
constexpr std::int64_t kFlushBytes = 4 << 20;

// Bounds on one object of a file that others wrote.
constexpr std::uint32_t kSmallSize = 4096;   // cannot do harm, nor can its square
constexpr std::uint64_t kMostPacked = 1032;  // times that deflate can pack anything
constexpr std::uint64_t kInMemory = 4;       // a list's member in memory by that in the file
constexpr std::uint64_t kAlwaysAllowed = 128 << 20;  // [byte]
constexpr std::uint64_t kNeverAllowed = 1 << 30;     // [byte]
constexpr std::int64_t kGrowth = 200;                // black images do not reach it

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
  std::unique_ptr<GzArchive> archive(new GzArchive(openOrThrow(path, "rb", "open"), path));
  std::error_code ignored;
  archive->file_bytes_ = static_cast<std::int64_t>(std::filesystem::file_size(path, ignored));
  return archive;
}

std::unique_ptr<GzArchive> GzArchive::forWriting(const std::string& path, int level) {
  const std::string mode = "wb" + std::to_string(std::clamp(level, 0, 9));
  return std::unique_ptr<GzArchive>(new GzArchive(openOrThrow(path, mode.c_str(), "write"), path));
}

std::unique_ptr<GzArchive> GzArchive::forRecording(const std::string& path, int level) {
  const int handle = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (handle < 0) throw std::runtime_error("cannot write " + path + ": " + std::strerror(errno));
  const std::string mode = level <= 0 ? "wbT" : "wb" + std::to_string(std::min(level, 9));
  gzFile file = gzdopen(dup(handle), mode.c_str());
  if (file == nullptr) {
    ::close(handle);
    throw std::runtime_error("cannot write " + path + ": out of memory");
  }
  gzbuffer(file, kRecordingBufferBytes);
  std::unique_ptr<GzArchive> archive(new GzArchive(file, path));
  archive->handle_ = handle;
  return archive;
}

void GzArchive::writeWhole(const mrpt::serialization::CSerializable& object) {
  try {
    const auto before = gztell(file_);
    *this << object;
    unflushed_ += gztell(file_) - before;
    const bool much = unflushed_ > kFlushBytes;
    if (much) flush();
    ++objects_;
    if (much) sound_objects_ = objects_;
  } catch (const std::exception& e) {
    cutBack();
    throw std::runtime_error(shortReason(e));
  }
}

void GzArchive::flush() {
  // Finished, so that a reader needs nothing of what follows: the next write begins a new member.
  if (gzflush(file_, Z_FINISH) != Z_OK) {
    const std::string reason = reasonOf(file_);
    cutBack();
    throw std::runtime_error("cannot write " + path_ + ": " + reason);
  }
  sound_ = lseek(handle_, 0, SEEK_END);
  sound_objects_ = objects_;
  unflushed_ = 0;
}

void GzArchive::cutBack() {
  if (handle_ < 0 || file_ == nullptr) return;
  gzclose(file_);  // tries to write what is left, in vain or not
  file_ = nullptr;
  cut_off_ = objects_ - sound_objects_;
  if (ftruncate(handle_, sound_) != 0) sound_ = -1;
}

GzArchive::~GzArchive() {
  if (file_ != nullptr) gzclose(file_);
  if (handle_ >= 0) ::close(handle_);
}

void GzArchive::close() {
  if (file_ == nullptr) return;
  errno = 0;
  const int code = gzclose(file_);
  file_ = nullptr;
  if (code == Z_OK) return;
  cut_off_ = objects_ - sound_objects_;
  if (handle_ >= 0 && ftruncate(handle_, sound_) != 0) sound_ = -1;
  throw std::runtime_error("cannot finish writing " + path_ + ": " +
                           (code == Z_ERRNO ? std::strerror(errno) : zError(code)));
}

std::string GzArchive::streamError() const {
  if (!problem_.empty()) return problem_;
  int code = Z_OK;
  gzerror(file_, &code);
  if (code == Z_OK || code == Z_STREAM_END) return {};
  if (code == Z_BUF_ERROR) return "the compressed stream ends early";
  return reasonOf(file_);
}

std::int64_t GzArchive::compressedPosition() const { return gzoffset(file_); }

mrpt::serialization::CSerializable::Ptr GzArchive::readBounded() {
  // Once more for each class of which MRPT has to be told first: few, and none in most files.
  for (;;) {
    const auto at = gztell(file_);
    try {
      return readObject();
    } catch (const std::exception& e) {
      if (!loadClassNamedIn(e.what()) || gzseek(file_, at, SEEK_SET) != at) throw;
    }
  }
}

mrpt::serialization::CSerializable::Ptr GzArchive::readObject() {
  object_at_ = gztell(file_);
  object_packed_at_ = gzoffset(file_);
  bounding_ = true;
  const auto done = [this](void*) {
    bounding_ = false;
    bound_.reset();
  };
  const std::unique_ptr<void, decltype(done)> guard(this, done);
  return ReadObject();
}

std::uint64_t GzArchive::mostLeft() const {
  const std::int64_t ahead = file_bytes_ - gzoffset(file_) + kBufferBytes;  // it reads by buffers
  const auto left = static_cast<std::uint64_t>(
      std::clamp<std::int64_t>(ahead, 0, std::max<std::int64_t>(file_bytes_, 0)));
  return gzdirect(file_) != 0 ? left : left * kMostPacked;
}

void GzArchive::checkGrowth() {
  // Where the file stands is a question to the system: not for every few bytes that MRPT reads.
  const std::int64_t unpacked = gztell(file_) - object_at_;
  if (unpacked <= kGrowth * kBufferBytes) return;
  const std::int64_t packed = gzoffset(file_) - object_packed_at_ + kBufferBytes;
  if (unpacked <= kGrowth * packed) return;
  // MRPT puts words of its own before what is thrown through it.
  problem_ =
      "an object unpacks to more than " + std::to_string(kGrowth) + " times its size in the file";
  throw std::runtime_error(problem_);
}

std::size_t GzArchive::write(const void* buf, std::size_t len) {
  if (file_ == nullptr) throw std::runtime_error(path_ + " is closed");
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
    if (bounding_) checkGrowth();
  }
  // What may be the number of something that MRPT makes room for next.
  if (bounding_ && !bound_ && len == sizeof(std::uint32_t) && done == len) {
    std::uint32_t size = 0;
    std::memcpy(&size, buf, sizeof size);
    if (size > kSmallSize) {
      bound_ = std::make_unique<MemoryBound>(
          std::min(kAlwaysAllowed + kInMemory * mostLeft(), kNeverAllowed));
    }
  }
  // MRPT's contract: nothing read at all is an error; it becomes CExceptionEOF between objects.
  if (done == 0 && len > 0) throw std::runtime_error("end of " + path_);
  return done;
}

}  // namespace vir::rawlog
