#pragma once
/// Small pictures of what the camera saw, with the features that were followed.
#include <mrpt/obs/CObservation.h>

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "vir/types/state.h"

namespace vir::results {

struct Thumbnail {
  TimeNs t = 0;                          ///< on the clock of the IMU
  int width = 0, height = 0;             ///< of the image itself [px]
  std::vector<unsigned char> jpeg;       ///< kWidth wide
  std::vector<Eigen::Vector2f> tracked;  ///< [px] of the image itself
  std::string why;                       ///< a change of health; empty: it was time for one
};

/// Keeps one every now and then, rarer as the run grows, and one where health changes.
class Thumbnails {
 public:
  /// Remembers an image; other observations are passed over.
  void see(const mrpt::obs::CObservation& observation);
  /// What was made of the image that was seen last.
  void add(const StateEstimate& estimate, const std::vector<Eigen::Vector2f>& tracked);
  const std::vector<Thumbnail>& kept() const { return kept_; }

  static constexpr int kWidth = 240;
  static constexpr std::size_t kRegular = 30, kChanges = 20;

 private:
  void thinOut();

  cv::Mat last_;
  std::vector<Thumbnail> kept_;
  std::size_t regular_ = 0, changes_ = 0;
  TimeNs every_ = 1'000'000'000, next_ = 0;
  Health health_ = Health::starting;
};

}  // namespace vir::results
