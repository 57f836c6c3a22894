#include "video_frames.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <opencv2/videoio/registry.hpp>
#include <optional>
#include <set>

#include "input_error.h"
#include "vir/core/text.h"
#include "vir/core/time_bounds.h"
#include "vir/tables/layout.h"

namespace vir::euroc {
namespace fs = std::filesystem;
namespace {

constexpr double kFrameStep = 0.033;  // [s], to tell the unit of times that are no dates
constexpr std::size_t kMostFrames = 5'000'000;
constexpr double kLeastApart = 0.005;  // [s], between two clocks' ideas of a frame's length

/// As numbers of other programs; what is no number is 0.
double property(const cv::VideoCapture& video, int which) {
  const double v = video.get(which);
  return std::isfinite(v) && v > 0 ? v : 0;
}

void open(const std::string& path, cv::VideoCapture* video) {
  std::error_code ec;
  if (!fs::is_regular_file(path, ec)) throw InputError(path + ": no such file");
  bool opened = false;
  try {
    // Others than FFmpeg know no times of frames, and complain on the terminal of what is none of
    // theirs.
    const bool ffmpeg = cv::videoio_registry::hasBackend(cv::CAP_FFMPEG);
    opened = video->open(path, ffmpeg ? cv::CAP_FFMPEG : cv::CAP_ANY);
    // OpenCV turns frames by itself; then they are not those that a calibration was made with.
    if (opened) video->set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
  } catch (const cv::Exception&) {
    opened = false;
  }
  if (!opened) {
    throw InputError(path +
                     ": cannot be opened as a video (empty, of a kind that OpenCV does not "
                     "know here, or cut off: an mp4 that was never closed lacks its index)");
  }
}

VideoInfo infoOf(const cv::VideoCapture& video, int turn_deg) {
  VideoInfo info;
  info.width = static_cast<int>(property(video, cv::CAP_PROP_FRAME_WIDTH));
  info.height = static_cast<int>(property(video, cv::CAP_PROP_FRAME_HEIGHT));
  info.rate_hz = property(video, cv::CAP_PROP_FPS);
  const double frames = property(video, cv::CAP_PROP_FRAME_COUNT);
  info.frames = frames < static_cast<double>(kMostFrames) ? std::lround(frames) : 0;
  info.turned = property(video, cv::CAP_PROP_ORIENTATION_META) != 0;
  if (turn_deg % 180 != 0) std::swap(info.width, info.height);
  return info;
}

/// One time for each row of the table, none where the row has no usable one.
std::vector<std::optional<TimeNs>> readTimes(const std::string& path, ProblemLog* log) {
  const tables::Layout layout = tables::layoutOf(path);
  const auto column = static_cast<std::size_t>(tables::stampColumn(layout));
  const tables::UnitGuess guess = tables::stampUnit(layout, static_cast<int>(column), kFrameStep);
  std::vector<std::optional<TimeNs>> times;
  std::vector<std::string_view> fields;
  tables::RowSplitter splitter(layout);
  LineReader lines(path);
  std::string line;
  while (lines.next(&line) && times.size() < kMostFrames) {
    splitter.split(line, &fields);
    TimeNs t = 0;
    const bool is_time =
        column < fields.size() && tables::parseStamp(fields[column], guess.unit, &t);
    const bool header = times.empty() && std::isalpha(static_cast<unsigned char>(line[0])) != 0;
    if (!is_time && header) continue;
    times.push_back(is_time && isStamp(t) ? std::optional<TimeNs>(t) : std::nullopt);
    if (is_time && t < 0) {
      log->add("image_before_zero", lines.where(), "a time before 0; its frame is not used");
    } else if (is_time && !isStamp(t)) {
      log->add("image_implausible", lines.where(), "a time after 2099; its frame is not used");
    } else if (!is_time) {
      log->add("image_malformed", lines.where(), "holds no time; its frame is not used");
    }
  }
  if (times.empty()) throw InputError(path + ": holds no times of frames");
  log->note(path + ": " + std::to_string(times.size()) + " times of frames in " +
            tables::name(guess.unit));
  return times;
}

class VideoRows : public RowStream<ImageRow> {
 public:
  VideoRows(const std::string& path, const VideoTimes& times, int turn_deg, ProblemLog* log)
      : path_(path), start_(times.start), table_(times.table), turn_deg_(turn_deg), log_(log) {
    open(path, &video_);
    info_ = infoOf(video_, turn_deg);
    if (!table_.empty()) times_ = readTimes(table_, log);
    sayWhatItIs();
    advance();
    if (!has_next_) {
      throw InputError(path + ": no frame of it could be decoded" +
                       (table_.empty() ? "" : " and has a time in " + table_));
    }
  }

  const ImageRow* peek() const override { return has_next_ ? &next_ : nullptr; }
  void pop() override { advance(); }
  std::string where() const override { return path_ + ", frame " + std::to_string(index_); }
  double progress() const override {
    if (!has_next_) return 1;
    return info_.frames == 0
               ? 0
               : std::min(1.0, static_cast<double>(index_) / static_cast<double>(info_.frames));
  }
  const std::string& path() const override { return path_; }
  const std::string& name() const override { return name_; }

 private:
  void sayWhatItIs() const {
    log_->note(path_ + ": " + describeVideo(info_) + "; its frames are taken over in grey");
    if (!info_.turned && turn_deg_ == 0) return;
    log_->note(
        path_ +
        (info_.turned ? ": players turn it as its file says, which is not followed here" : "") +
        ": its frames are " +
        (turn_deg_ == 0 ? "as the camera gave them (turn_video = 90, 180 or 270 turns them)"
                        : "turned by " + std::to_string(turn_deg_) + " degrees clockwise") +
        ", and the calibration must be that of such frames");
  }

  /// The next frame, not yet unpacked; false at the end.
  bool grab() {
    try {
      if (static_cast<std::size_t>(index_) < kMostFrames && video_.grab()) {
        ++index_;
        return true;
      }
    } catch (const cv::Exception& e) {
      log_->note(where() + ": " + e.what());
    }
    return false;
  }

  /// Since the first frame, by the file [ns].
  TimeNs timeInFile() {
    const double ms = property(video_, cv::CAP_PROP_POS_MSEC);
    auto t = static_cast<TimeNs>(std::llround(std::min(ms, 1e12) * 1e6));
    if (index_ == 1) first_in_file_ = t;
    t -= first_in_file_;
    // Streams that were never put into a container hold no times.
    if (index_ == 2 && t <= 0 && info_.rate_hz > 0) {
      by_rate_ = true;
      log_->note(path_ + ": holds no times of its frames; they are taken to be evenly spaced");
    }
    return by_rate_ ? static_cast<TimeNs>(
                          std::llround(1e9 * static_cast<double>(index_ - 1) / info_.rate_hz))
                    : t;
  }

  /// Its time; false, and counted, if there is none.
  bool timeOf(TimeNs* t) {
    const TimeNs in_file = timeInFile();
    if (table_.empty()) {
      *t = start_ + in_file;
      return true;
    }
    const auto at = static_cast<std::size_t>(index_ - 1);
    if (at >= times_.size()) {
      log_->add("image_without_stamp", where(), table_ + " has no further times");
      return false;
    }
    if (!times_[at]) return false;  // counted already
    *t = *times_[at];
    compare(*t, in_file);
    return true;
  }

  /// A table that lacks a row, or has one too many, shows where the two disagree.
  void compare(TimeNs t, TimeNs in_file) {
    if (compared_ && !by_rate_) {
      const double apart = toSeconds((t - last_table_) - (in_file - last_in_file_));
      const double most =
          std::max(kLeastApart, info_.rate_hz > 0 ? 0.5 / info_.rate_hz : kFrameStep / 2);
      if (std::abs(apart) > most) {
        char text[120];
        std::snprintf(text, sizeof text,
                      "is %.4f s after the frame before by the table, %.4f s by the video",
                      toSeconds(t - last_table_), toSeconds(in_file - last_in_file_));
        log_->add("image_times_disagree", where(), text);
      }
    }
    compared_ = true;
    last_table_ = t;
    last_in_file_ = in_file;
  }

  bool unpack() {
    try {
      cv::Mat frame;
      if (!video_.retrieve(frame) || frame.empty()) return false;
      // A buffer of its own: the row before may still be in use.
      next_.pixels = cv::Mat();
      if (frame.channels() == 1) {
        next_.pixels = frame.clone();
      } else {
        cv::cvtColor(frame, next_.pixels,
                     frame.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
      }
      if (turn_deg_ != 0) {
        cv::Mat turned;
        cv::rotate(next_.pixels, turned, turn_deg_ / 90 - 1);  // as cv::RotateFlags are numbered
        next_.pixels = turned;
      }
      return true;
    } catch (const cv::Exception&) {
      return false;
    }
  }

  void advance() {
    has_next_ = false;
    while (grab()) {
      TimeNs t = 0;
      if (!timeOf(&t)) continue;
      if (t <= last_t_) {
        log_->add(t == last_t_ ? "image_repeated" : "image_too_late", where(),
                  "its time is not after that of the frame before; not used");
      } else if (!unpack()) {
        log_->add("image_undecodable", where(), "cannot be decoded");
      } else {
        last_t_ = next_.t = t;
        next_.file = path_;
        has_next_ = true;
        return;
      }
    }
    finish();
  }

  void finish() {
    if (finished_) return;
    finished_ = true;
    const auto frames = static_cast<std::size_t>(index_);
    if (!table_.empty() && times_.size() != frames) {
      log_->note(table_ + ": has " + std::to_string(times_.size()) + " times for " +
                 std::to_string(frames) + " frames of " + path_ +
                 ": they were given out from the first on; is it the table of this video?");
    }
    if (!table_.empty() && times_.size() > frames) {
      log_->count("image_times_left_over", static_cast<long>(times_.size() - frames));
    }
    // What the head says is an estimate in some files.
    const long missing = info_.frames - index_;
    if (missing <= std::max<long>(1, info_.frames / 100)) return;
    log_->note(path_ + ": is damaged or cut off after frame " + std::to_string(index_) + " of " +
               std::to_string(info_.frames) + "; what comes before is used");
    log_->count("damage");  // roles::kDamageCounter
  }

  std::string path_, name_ = "image";
  TimeNs start_ = 0;
  std::string table_;
  int turn_deg_ = 0;
  ProblemLog* log_;
  cv::VideoCapture video_;
  VideoInfo info_;
  std::vector<std::optional<TimeNs>> times_;
  ImageRow next_;
  long index_ = 0;  ///< of the frame at hand, from 1
  TimeNs first_in_file_ = 0, last_t_ = -1, last_table_ = 0, last_in_file_ = 0;
  bool has_next_ = false, finished_ = false, by_rate_ = false, compared_ = false;
};

}  // namespace

bool isVideoFile(const std::string& path) {
  const std::string e = lowerCase(fs::path(path).extension().string());
  static const std::set<std::string> known{".mp4", ".mov",  ".m4v", ".avi", ".mkv",
                                           ".3gp", ".webm", ".mpg", ".mpeg"};
  return known.count(e) > 0;
}

VideoInfo lookAtVideo(const std::string& path, int turn_deg) {
  cv::VideoCapture video;
  open(path, &video);
  return infoOf(video, turn_deg);
}

std::string describeVideo(const VideoInfo& info) {
  char text[120];
  std::snprintf(text, sizeof text, "video, %dx%d, %.4g Hz, %ld frames", info.width, info.height,
                info.rate_hz, info.frames);
  return text;
}

std::unique_ptr<RowStream<ImageRow>> openVideo(const std::string& path, const VideoTimes& times,
                                               int turn_deg, ProblemLog* log) {
  return std::make_unique<VideoRows>(path, times, turn_deg, log);
}

}  // namespace vir::euroc
