/// The film of `view --video`: the image with its tracks, and the map from above beside it; see
/// openVideoView().
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationImage.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <stdexcept>

#include "live/live_view.h"
#include "vir/rawlog/gray_image.h"
#include "vir/rawlog/labels.h"

namespace vir::app {
namespace {

constexpr int kHeight = 480, kMapWidth = 480, kText = 40;  // [px]
constexpr double kFramesPerSecond = 20, kMargin = 0.12, kSmallestMap = 2,
                 kFarthestAnchor = 200;  // [m]
constexpr int kMapEvery = 10;            // keyframes between two looks at the map points

cv::Scalar paper() { return {250, 250, 250}; }
cv::Scalar ink() { return {40, 40, 40}; }
cv::Scalar faint() { return {225, 225, 225}; }
cv::Scalar stone() { return {190, 190, 190}; }
cv::Scalar blue() { return {178, 114, 0}; }
cv::Scalar orange() { return {0, 94, 213}; }
cv::Scalar green() { return {90, 220, 0}; }

/// From W, seen from above with x to the right, to the picture.
class MapScale {
 public:
  void include(const Vec3& p) {
    least_ = least_ ? Eigen::Vector2d(least_->cwiseMin(p.head<2>())) : Eigen::Vector2d(p.head<2>());
    most_ = most_ ? Eigen::Vector2d(most_->cwiseMax(p.head<2>())) : Eigen::Vector2d(p.head<2>());
  }
  double pixelsPerMetre() const {
    const double side = std::max((*most_ - *least_).maxCoeff(), kSmallestMap);
    return kMapWidth * (1 - 2 * kMargin) / side;
  }
  cv::Point2d at(const Vec3& p) const {
    const Eigen::Vector2d middle = 0.5 * (*least_ + *most_);
    const double k = pixelsPerMetre();
    return {kMapWidth / 2.0 + k * (p.x() - middle.x()), kHeight / 2.0 - k * (p.y() - middle.y())};
  }
  bool empty() const { return !least_; }

 private:
  std::optional<Eigen::Vector2d> least_, most_;
};

class VideoView final : public LiveView {
 public:
  VideoView(std::string file, double speed)
      : file_(std::move(file)), frame_every_(fromSeconds(speed / kFramesPerSecond)) {}

  void setEstimate(const StateEstimate& e, const roles::Estimator& estimator) override {
    estimate_ = e;
    pixels_ = estimator.trackedPixels();
    anchors_ = estimator.anchors();
    for (const Anchor& a : anchors_) {
      if (a.has_position && a.p_W.allFinite() && a.p_W.norm() < kFarthestAnchor)
        scale_.include(a.p_W);
    }
    if (e.valid && e.state.T_W_B.p.allFinite()) {
      if (path_.empty() || e.segment != segment_) path_.emplace_back();
      segment_ = e.segment;
      path_.back().push_back(e.state.T_W_B.p);
      scale_.include(e.state.T_W_B.p);
    }
    if (e.keyframe && keyframes_++ % kMapEvery == 0) landmarks_ = estimator.landmarks();
  }
  void setBegin(TimeNs t) override { first_ = t; }
  void setRevision(const Revision&) override {}
  void setObservation(const mrpt::obs::CObservation::Ptr& observation) override {
    if (auto image = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(observation)) {
      // Of a rig's cameras the first.
      if (!image_ || image->sensorLabel <= image_->sensorLabel) image_ = image;
    } else if (auto ranges =
                   std::dynamic_pointer_cast<mrpt::obs::CObservationBeaconRanges>(observation)) {
      if (ranges->sensorLabel == rawlog::kPeerLabel) return;
      for (const auto& r : ranges->sensedData) {
        range_of_[static_cast<std::uint64_t>(r.beaconID)] = ranges->timestamp;
      }
    }
  }

  void draw() override {
    const TimeNs t = estimate_.state.t;
    if (!image_ || (next_ != 0 && t < next_)) return;
    if (next_ == 0) next_ = t;
    const cv::Mat frame = picture();
    open(frame.size());
    // A hole in the recording is one in the film as well: the picture stays.
    for (; next_ <= t; next_ += frame_every_) writer_.write(frame);
  }
  bool closed() const override { return false; }

 private:
  void open(cv::Size size) {
    if (writer_.isOpened()) return;
    const bool avi = file_.size() > 4 && file_.compare(file_.size() - 4, 4, ".avi") == 0;
    const int codec = avi ? cv::VideoWriter::fourcc('M', 'J', 'P', 'G')
                          : cv::VideoWriter::fourcc('m', 'p', '4', 'v');
    if (!writer_.open(file_, codec, kFramesPerSecond, size)) {
      throw std::runtime_error("cannot write the film " + file_ +
                               ": is the folder there, and the name one of .mp4 or .avi?");
    }
  }

  cv::Mat picture() const {
    const cv::Mat image = cameraPicture();
    cv::Mat frame(kHeight + kText, image.cols + kMapWidth, CV_8UC3, paper());
    image.copyTo(frame(cv::Rect(0, 0, image.cols, kHeight)));
    cv::Mat map = frame(cv::Rect(image.cols, 0, kMapWidth, kHeight));
    drawMap(&map);
    cv::putText(frame, words(), {12, kHeight + 27}, cv::FONT_HERSHEY_SIMPLEX, 0.55, ink(), 1,
                cv::LINE_AA);
    return frame;
  }

  cv::Mat cameraPicture() const {
    const cv::Mat gray = rawlog::grayOf(*image_);
    const double scale = static_cast<double>(kHeight) / gray.rows;
    cv::Mat small, out;
    cv::resize(gray, small, {static_cast<int>(std::lround(scale * gray.cols)) & ~1, kHeight}, 0, 0,
               cv::INTER_AREA);
    if (small.depth() != CV_8U) small.convertTo(small, CV_8U, 1.0 / 256);
    cv::cvtColor(small, out, cv::COLOR_GRAY2BGR);
    for (const Eigen::Vector2f& px : pixels_) {
      cv::circle(out, cv::Point2d(scale * px.x(), scale * px.y()), 3, green(), 1, cv::LINE_AA);
    }
    return out;
  }

  void drawMap(cv::Mat* map) const {
    if (scale_.empty()) return;
    drawGrid(map);
    for (const Landmark& l : landmarks_) {
      if (l.p_W.allFinite()) cv::circle(*map, scale_.at(l.p_W), 1, stone(), cv::FILLED);
    }
    for (const auto& part : path_) {
      std::vector<cv::Point> line;
      for (const Vec3& p : part) line.emplace_back(scale_.at(p));
      cv::polylines(*map, line, false, blue(), 2, cv::LINE_AA);
    }
    if (path_.empty()) return;
    drawAnchors(map);
    const Pose& T = estimate_.state.T_W_B;
    const cv::Point2d here = scale_.at(path_.back().back());
    cv::circle(*map, here, 5, blue(), cv::FILLED, cv::LINE_AA);
    if (!estimate_.valid) return;
    const Vec3 ahead = T.q * (estimate_.calibration.T_B_C.q * Vec3::UnitZ());
    cv::line(*map, here, here + 18 * cv::Point2d(ahead.x(), -ahead.y()), blue(), 2, cv::LINE_AA);
  }

  void drawGrid(cv::Mat* map) const {
    const double k = scale_.pixelsPerMetre();
    double step = 1;
    while (step * k < 40) step *= step * k < 20 ? 5 : 2;
    const cv::Point2d origin = scale_.at(Vec3::Zero());
    for (double x = std::fmod(origin.x, step * k); x < kMapWidth; x += step * k) {
      cv::line(*map, cv::Point2d(x, 0), cv::Point2d(x, kHeight), faint());
    }
    for (double y = std::fmod(origin.y, step * k); y < kHeight; y += step * k) {
      cv::line(*map, cv::Point2d(0, y), cv::Point2d(kMapWidth, y), faint());
    }
    char label[32];
    std::snprintf(label, sizeof label, "grid %g m", step);
    cv::putText(*map, label, {10, kHeight - 10}, cv::FONT_HERSHEY_SIMPLEX, 0.45, ink(), 1,
                cv::LINE_AA);
  }

  void drawAnchors(cv::Mat* map) const {
    for (const Anchor& a : anchors_) {
      if (!a.has_position || !a.p_W.allFinite()) continue;
      const cv::Point2d at = scale_.at(a.p_W);
      if (range_of_.count(a.id) != 0) {
        cv::line(*map, scale_.at(path_.back().back()), at, orange(), 1, cv::LINE_AA);
      }
      const double sigma = std::sqrt(std::max(a.covariance.topLeftCorner<2, 2>().trace() / 2, 0.0));
      const double radius = std::clamp(2 * sigma * scale_.pixelsPerMetre(), 4.0, 1000.0);
      cv::circle(*map, at, static_cast<int>(radius), orange(), 1, cv::LINE_AA);
      cv::circle(*map, at, 3, orange(), cv::FILLED, cv::LINE_AA);
      cv::putText(*map, "anchor " + std::to_string(a.id), at + cv::Point2d(8, -8),
                  cv::FONT_HERSHEY_SIMPLEX, 0.4, ink(), 1, cv::LINE_AA);
    }
  }

  std::string words() const {
    char text[200];
    std::snprintf(text, sizeof text, "%6.1f s   %s   %d tracks, %d points",
                  toSeconds(estimate_.state.t - first_), healthText(estimate_).c_str(),
                  estimate_.tracks, estimate_.landmarks);
    return text;
  }

  const std::string file_;
  const TimeNs frame_every_;
  cv::VideoWriter writer_;
  TimeNs first_ = 0, next_ = 0;
  StateEstimate estimate_;
  int keyframes_ = 0, segment_ = 0;
  std::vector<Eigen::Vector2f> pixels_;
  std::vector<Anchor> anchors_;
  std::vector<Landmark> landmarks_;
  std::vector<std::vector<Vec3>> path_;  // of each segment
  std::map<std::uint64_t, mrpt::Clock::time_point> range_of_;
  std::shared_ptr<mrpt::obs::CObservationImage> image_;
  MapScale scale_;
};

}  // namespace
}  // namespace vir::app

extern "C" __attribute__((visibility("default"))) vir::app::LiveView* virOpenVideoView(
    const std::string& file, double speed) {
  return new vir::app::VideoView(file, speed);
}
