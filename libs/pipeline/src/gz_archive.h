#pragma once
/// MRPT archive over zlib. MRPT's own gz streams do not report a full disk or a truncated file.
#include <mrpt/serialization/CArchive.h>
#include <zlib.h>

#include <cstdint>
#include <memory>
#include <string>

namespace vir {

class GzArchive : public mrpt::serialization::CArchive {
 public:
  /// Opens for reading (gzip or plain). Throws std::runtime_error naming file and reason.
  static std::unique_ptr<GzArchive> forReading(const std::string& path);
  /// Creates the file. `level` 0..9.
  static std::unique_ptr<GzArchive> forWriting(const std::string& path, int level);
  ~GzArchive() override;

  /// Flushes and closes; throws std::runtime_error if that loses data.
  void close();
  /// Reading: empty while the stream is sound, else what zlib says (truncated, bad data).
  std::string streamError() const;
  /// Reading: position in the file as stored on disk [byte].
  std::int64_t compressedPosition() const;

 protected:
  std::size_t write(const void* buf, std::size_t len) override;
  std::size_t read(void* buf, std::size_t len) override;

 private:
  GzArchive(gzFile file, std::string path) : file_(file), path_(std::move(path)) {}
  gzFile file_ = nullptr;
  std::string path_;
};

}  // namespace vir
