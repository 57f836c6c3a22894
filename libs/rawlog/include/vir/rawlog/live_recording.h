#pragma once
#include <mrpt/obs/CObservation.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "vir/core/options.h"
#include "vir/core/time.h"

namespace vir::rawlog {

struct LiveRecordingOptions {
  std::string images = "jpg";  ///< jpg, png or embed
  int jpeg_quality = 90;
  int compression = 0;    ///< of the rawlog itself, 0..9; 0 = none at all
  double flush_s = 0.25;  ///< what is younger can be lost when the power goes
  double split_mb = 0;    ///< a new file beyond this size, images not counted; 0 = never
  double split_s = 0;     ///< a new file after so long; 0 = never
};
void describe(OptionVisitor& v, LiveRecordingOptions& o);

/// A rawlog that can be read at any moment, whatever becomes of this program: the file has its name
/// from the beginning and grows by whole observations. Images go to `<name>_Images` as files, or
/// into the rawlog. Further parts are `<name>_part2.rawlog`, ...; observations that are not in
/// order go to `<name>_late.rawlog`.
class LiveRecording {
 public:
  /// `path` must end in .rawlog. Throws std::runtime_error: the file, or one of its parts or
  /// folders of images, exists already or cannot be created.
  LiveRecording(const std::string& path, const LiveRecordingOptions& options);
  /// Closes what is open, errors ignored: call close().
  ~LiveRecording();
  LiveRecording(const LiveRecording&) = delete;
  LiveRecording& operator=(const LiveRecording&) = delete;

  /// Throws as the constructor does if anything of that name exists; creates nothing.
  static void requireNew(const std::string& path);

  /// Does not change the observation. Throws std::runtime_error when it cannot be written (disk
  /// full); the file then ends with the last whole observation and nothing more can be written.
  void write(const mrpt::obs::CObservation& observation, bool in_order);
  /// Hands everything written so far to the operating system, and asks it to put it on the disk.
  /// Throws like write().
  void flush();
  /// Throws like write().
  void close();

  /// Observations in the files; what a full disk cut off again is not counted.
  std::size_t written() const { return written_; }
  std::size_t asideCount() const { return aside_count_; }
  /// Parts so far, the first being `path`.
  const std::vector<std::string>& parts() const { return parts_; }
  std::string asidePath() const;

 private:
  struct File;
  class DiskSync;
  void open();
  void writeInto(const mrpt::obs::CObservation& observation, bool in_order);
  void writeTo(File& file, const mrpt::obs::CObservation& observation);
  bool partIsFull(TimeNs t) const;
  void forgetCutOff();
  void forgetEmptyFile();

  std::string stem_;
  LiveRecordingOptions options_;
  bool images_inside_;
  std::unique_ptr<DiskSync> sync_;
  std::unique_ptr<File> file_, aside_;
  std::vector<std::string> parts_;
  std::size_t written_ = 0, aside_count_ = 0;
};

}  // namespace vir::rawlog
