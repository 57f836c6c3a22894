#pragma once
/// A video as the images of a camera.
#include <memory>
#include <string>

#include "problem_log.h"
#include "readers.h"

namespace vir::euroc {

/// By its ending.
bool isVideoFile(const std::string& path);

struct VideoInfo {
  int width = 0, height = 0;  ///< [px], of the frames as they are given out
  double rate_hz = 0;         ///< as the file says; 0: it does not
  long frames = 0;            ///< as the file says; 0: it does not
  bool turned = false;        ///< the file asks players to turn it
};

/// Opens it and looks at what its head says. `turn_deg`: of the frames, clockwise, a multiple of
/// 90; whatever the file says, since versions of OpenCV take that for different directions. Throws
/// InputError if it cannot be opened as a video.
VideoInfo lookAtVideo(const std::string& path, int turn_deg);
/// "video, 640x480, 30 Hz, 900 frames".
std::string describeVideo(const VideoInfo& info);

struct VideoTimes {
  /// A table with the time of each frame, in their order, in any unit; empty: those of the file.
  std::string table;
  /// Of the first frame, where the file's times are used, which begin with 0 [ns].
  TimeNs start = 0;
};

/// The frames in grey, in the order of time; rows hold their pixels. What cannot be used is counted
/// in the log under "image_...", a video that ends before its head says under "damage". Throws
/// InputError if it cannot be opened, or no frame of it can be decoded.
std::unique_ptr<RowStream<ImageRow>> openVideo(const std::string& path, const VideoTimes& times,
                                               int turn_deg, ProblemLog* log);

}  // namespace vir::euroc
