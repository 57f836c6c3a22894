#pragma once
/// Exposure and contrast of images, and whether they are new ones.
#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "vir/check/finding.h"
#include "vir/core/time.h"

namespace vir::check {

/// Whether the IMU moves between two times of the images' clock; nothing where that is not known.
using Moves = std::function<std::optional<bool>(TimeNs, TimeNs)>;

/// Memory: some bytes an image.
class ImageCheck {
 public:
  explicit ImageCheck(std::string label) : label_(std::move(label)) {}
  /// One channel of 8 bits; in order of time. False: it is the one before once more.
  bool add(TimeNs t, const cv::Mat& gray);
  /// One that could not be loaded or decoded, and why.
  void addUnreadable(const std::string& why) {
    if (unreadable_++ == 0) first_unreadable_ = why;
  }
  /// Corners that were found in an image.
  void addCorners(int corners) { corners_.push_back(corners); }
  /// `expected_*`: size in the calibration [px], 0: not known. `moves` may be empty: that images
  /// stay the same for long is a fault only where the IMU moves. `further`: a camera beside the
  /// one that a run looks through.
  std::vector<Finding> findings(int expected_width, int expected_height, const Moves& moves = {},
                                bool further = false) const;

 private:
  struct Seen {
    TimeNs t = 0;
    float mean = 0, contrast = 0;  ///< grey value, and its standard deviation
    bool same = false;             ///< as the one before
  };
  /// From the first bad image on to the next good one, or the last there is.
  struct Stretch {
    TimeNs from = 0, to = 0;
    std::string kind, how;
    double mean = 0, contrast = 0;  ///< medians
  };
  std::vector<Stretch> darkStretches() const;
  std::vector<Stretch> frozenStretches() const;
  void checkSize(int width, int height, std::vector<Finding>* out) const;
  void checkLight(bool further, const std::vector<Stretch>& frozen,
                  std::vector<Finding>* out) const;
  std::vector<Stretch> stuckStretches(const Moves& moves, long* repeats) const;
  void checkFrozen(const std::vector<Stretch>& stuck, long repeats,
                   std::vector<Finding>* out) const;
  std::string when(const std::vector<Stretch>& stretches) const;

  std::string label_, first_unreadable_;
  std::vector<Seen> seen_;
  std::vector<int> corners_;
  cv::Mat last_;
  long unreadable_ = 0, count_ = 0;
  int width_ = 0, height_ = 0;
  bool sizes_differ_ = false;
};

}  // namespace vir::check
