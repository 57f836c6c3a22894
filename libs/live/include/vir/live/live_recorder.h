#pragma once
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "vir/live/acquisition.h"
#include "vir/live/live_merger.h"
#include "vir/rawlog/live_recording.h"

namespace vir::live {

/// Merges what comes in and writes it, in a thread of its own: a slow disk holds up nobody.
class LiveRecorder {
 public:
  /// Throws like LiveRecording.
  LiveRecorder(const std::string& path, const rawlog::LiveRecordingOptions& recording,
               const LiveMergerOptions& merging, std::size_t sensors);
  /// Ends as close() does, errors ignored.
  ~LiveRecorder();

  void add(const std::vector<Arrival>& arrivals);
  /// The sensor will send nothing for a while: others do not wait for it.
  void setEnded(std::size_t sensor);
  /// Writes everything that is held and closes the file. Throws std::runtime_error if anything
  /// could not be written, now or before.
  void close();

  /// Why nothing more is written; empty while all is well.
  std::string problem() const;
  struct Counts {
    std::size_t written = 0;  ///< in order
    std::size_t aside = 0;    ///< in the file of those that were too late
    std::size_t lost = 0;     ///< could not be written
    double behind_s = 0;      ///< longest that anything waited for its turn
    std::vector<std::string> files;
  };
  Counts counts() const;

 private:
  void work();
  void writeReady(TimeNs now);
  void tellCounts();

  const rawlog::LiveRecordingOptions options_;
  rawlog::LiveRecording recording_;  // of the thread
  LiveMerger merger_;                // of the thread
  std::size_t taken_ = 0;            // of the thread: out of the merger
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<Arrival> queue_;
  std::vector<std::size_t> ended_;
  bool closing_ = false;
  std::string problem_;
  Counts counts_;
  std::thread thread_;
};

}  // namespace vir::live
