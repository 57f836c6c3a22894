#pragma once
#include <mrpt/obs/CObservation.h>

#include <cstddef>
#include <memory>
#include <string>

namespace vir::rawlog {

class GzArchive;

/// Writes observations to a rawlog, one by one, without keeping them. The file appears under its
/// name only when complete: until finish() it is `<path>.part`.
class RawlogWriter {
 public:
  /// `compression` 0 (stored) to 9. Creates the folder of `path` if need be. Throws
  /// std::runtime_error naming file and reason if it cannot be written.
  explicit RawlogWriter(const std::string& path, int compression = 1);
  /// Without finish(), the unfinished `.part` file is removed.
  ~RawlogWriter();
  RawlogWriter(const RawlogWriter&) = delete;
  RawlogWriter& operator=(const RawlogWriter&) = delete;

  /// Throws std::runtime_error, e.g. when the disk is full.
  void write(const mrpt::obs::CObservation& observation);
  /// Closes the file and gives it its name. Throws std::runtime_error if that fails: then there is
  /// no file.
  void finish();

  std::size_t written() const { return written_; }
  /// Where external images of this rawlog belong: `<path without .rawlog>_Images`. Not created
  /// here.
  std::string imageFolder() const;
  /// The same for any rawlog path (`x.rawlog`, `x.rawlog.gz`).
  static std::string imageFolderOf(const std::string& rawlog_path);

 private:
  std::string path_;
  std::unique_ptr<GzArchive> archive_;
  std::size_t written_ = 0;
};

}  // namespace vir::rawlog
