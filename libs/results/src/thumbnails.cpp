#include "thumbnails.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "vir/rawlog/gray_image.h"

namespace vir::results {
namespace {

constexpr int kQuality = 55;
constexpr std::size_t kMostTracks = 150;

std::vector<unsigned char> smallJpeg(const cv::Mat& pixels) {
  const double scale = std::min(1.0, static_cast<double>(Thumbnails::kWidth) / pixels.cols);
  cv::Mat small;
  cv::resize(pixels, small, {}, scale, scale, cv::INTER_AREA);
  std::vector<unsigned char> jpeg;
  cv::imencode(".jpg", small, jpeg, {cv::IMWRITE_JPEG_QUALITY, kQuality});
  return jpeg;
}

}  // namespace

void Thumbnails::see(const mrpt::obs::CObservation& observation) {
  const auto image = rawlog::grayImageOf(observation);
  // The pixels are the observation's, which outlives the estimate of its image.
  if (image && image->pixels.depth() == CV_8U) last_ = image->pixels;
}

void Thumbnails::add(const StateEstimate& estimate, const std::vector<Eigen::Vector2f>& tracked) {
  const bool changed = estimate.health != health_ && changes_ < kChanges;
  const bool due = kept_.empty() || estimate.state.t >= next_;
  health_ = estimate.health;
  if (last_.empty() || (!changed && !due)) return;
  Thumbnail t;
  t.t = estimate.state.t;
  t.width = last_.cols;
  t.height = last_.rows;
  t.jpeg = smallJpeg(last_);
  t.tracked.assign(tracked.begin(), tracked.begin() + static_cast<std::ptrdiff_t>(
                                                          std::min(tracked.size(), kMostTracks)));
  if (changed) t.why = healthText(estimate);
  kept_.push_back(std::move(t));
  last_ = cv::Mat();
  next_ = estimate.state.t + every_;
  ++(changed ? changes_ : regular_);
  if (regular_ >= 2 * kRegular) thinOut();
}

void Thumbnails::thinOut() {
  std::vector<Thumbnail> left;
  bool keep = false;
  regular_ = 0;
  for (Thumbnail& t : kept_) {
    if (t.why.empty()) {
      keep = !keep;
      if (!keep) continue;
      ++regular_;
    }
    left.push_back(std::move(t));
  }
  kept_ = std::move(left);
  every_ *= 2;
}

}  // namespace vir::results
