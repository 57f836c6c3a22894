#pragma once
/// MRPT archive over zlib. MRPT's own gz streams do not report a full disk or a truncated file.
#include <mrpt/serialization/CArchive.h>
#include <zlib.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "memory_bound.h"

namespace vir::rawlog {

class GzArchive : public mrpt::serialization::CArchive {
 public:
  /// Opens for reading (gzip or plain). Throws std::runtime_error naming file and reason.
  static std::unique_ptr<GzArchive> forReading(const std::string& path);
  /// Creates the file. `level` 0..9.
  static std::unique_ptr<GzArchive> forWriting(const std::string& path, int level);
  /// Creates a file that must not exist yet and is sound at any moment: see writeWhole(). `level` 0
  /// stores plain objects without gzip's frame.
  static std::unique_ptr<GzArchive> forRecording(const std::string& path, int level);
  ~GzArchive() override;

  /// The next object of a file that others wrote. As ReadObject(), but what it says of its own size
  /// is not believed: std::bad_alloc when it asks for more memory than the rest of the file can
  /// fill, std::runtime_error when it unpacks to very much more than it is on the disk.
  mrpt::serialization::CSerializable::Ptr readBounded();

  /// An object in one piece: if it cannot be written, the file is cut back to the object before and
  /// std::runtime_error thrown.
  void writeWhole(const mrpt::serialization::CSerializable& object);
  /// Hands what was written to the operating system; throws std::runtime_error if it does not take
  /// it (disk full), the file then being cut back to what was flushed before.
  void flush();
  /// Objects that writeWhole() had taken and that were cut off again, since the last call.
  std::size_t takeCutOff() { return std::exchange(cut_off_, 0); }
  /// Bytes handed over so far, compressed.
  std::int64_t bytesWritten() const { return compressedPosition(); }

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
  mrpt::serialization::CSerializable::Ptr readObject();
  void cutBack();
  std::uint64_t mostLeft() const;
  void checkGrowth();
  GzArchive(gzFile file, std::string path) : file_(file), path_(std::move(path)) {}
  gzFile file_ = nullptr;
  std::string path_, problem_;
  int handle_ = -1;         // of a recording, to cut it back
  std::int64_t sound_ = 0;  // length of the file up to the last flush
  std::int64_t unflushed_ = 0;
  std::size_t objects_ = 0, sound_objects_ = 0, cut_off_ = 0;
  std::int64_t file_bytes_ = 0;  // reading
  std::int64_t object_at_ = 0, object_packed_at_ = 0;
  bool bounding_ = false;
  std::unique_ptr<MemoryBound> bound_;  // of the object that is being read
};

}  // namespace vir::rawlog
