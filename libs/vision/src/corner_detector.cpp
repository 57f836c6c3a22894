#include "vir/vision/corner_detector.h"

#include <algorithm>
#include <cmath>

namespace vir::vision {

namespace {
constexpr int kRadius = 3;   // the gradient tensor is summed over 7 x 7 px
constexpr int kRest = 4;     // images a cell without corners is left alone
constexpr int kPerCell = 4;  // candidates kept of a cell
constexpr float kScale = 1.0f / (32.0f * 32.0f * (2 * kRadius + 1) * (2 * kRadius + 1));

/// Offset in [-0.5, 0.5] of the peak of the parabola through three scores.
float peakOffset(float left, float centre, float right) {
  const float curvature = left - 2.0f * centre + right;
  if (!(curvature < 0.0f)) return 0.0f;
  return std::clamp(0.5f * (left - right) / curvature, -0.5f, 0.5f);
}
}  // namespace

bool CornerDetector::blocked(const cv::Point2f& p, const std::vector<cv::Point2f>& others) const {
  const float limit = static_cast<float>(options_.min_distance_px * options_.min_distance_px);
  for (const cv::Point2f& o : others) {
    const cv::Point2f d = p - o;
    if (d.dot(d) < limit) return true;
  }
  return false;
}

void CornerDetector::scoreRegion(const cv::Mat& gradient, const cv::Rect& region) {
  // Box sums of xx, xy, yy: first along each row into rows_, then down the columns.
  const int w = region.width;
  const int padded = w + 2 * kRadius;
  rows_.create(region.height + 2 * kRadius, 3 * w, CV_32FC1);
  std::vector<float> product(3 * padded);
  for (int y = 0; y < rows_.rows; ++y) {
    const short* g = gradient.ptr<short>(region.y + y - kRadius) + 2 * (region.x - kRadius);
    float* xx = product.data();
    float* xy = xx + padded;
    float* yy = xy + padded;
    for (int x = 0; x < padded; ++x) {
      const float gx = g[2 * x], gy = g[2 * x + 1];
      xx[x] = gx * gx;
      xy[x] = gx * gy;
      yy[x] = gy * gy;
    }
    float* out = rows_.ptr<float>(y);
    for (int channel = 0; channel < 3; ++channel) {
      const float* in = product.data() + channel * padded;
      float* o = out + channel * w;
      for (int x = 0; x < w; ++x) {
        o[x] = in[x] + in[x + 1] + in[x + 2] + in[x + 3] + in[x + 4] + in[x + 5] + in[x + 6];
      }
    }
  }
  score_.create(region.height, w, CV_32FC1);
  std::vector<float> sum(3 * w);
  for (int y = 0; y < region.height; ++y) {
    std::fill(sum.begin(), sum.end(), 0.0f);
    for (int k = 0; k <= 2 * kRadius; ++k) {
      const float* in = rows_.ptr<float>(y + k);
      for (int x = 0; x < 3 * w; ++x) sum[x] += in[x];
    }
    float* out = score_.ptr<float>(y);
    for (int x = 0; x < w; ++x) {
      const float a = sum[x], b = sum[w + x], c = sum[2 * w + x];
      const float d = a - c;
      out[x] = 0.5f * kScale * (a + c - std::sqrt(d * d + 4.0f * b * b));
    }
  }
}

bool CornerDetector::collectCell(const cv::Mat& gradient, const cv::Rect& cell, int occupancy) {
  // One pixel more on each side, so that maxima on the edge of the cell are seen as such.
  const cv::Rect region(cell.x - 1, cell.y - 1, cell.width + 2, cell.height + 2);
  scoreRegion(gradient, region);
  const std::size_t first = candidates_.size();
  for (int y = 1; y + 1 < region.height; ++y) {
    const float* up = score_.ptr<float>(y - 1);
    const float* row = score_.ptr<float>(y);
    const float* down = score_.ptr<float>(y + 1);
    for (int x = 1; x + 1 < region.width; ++x) {
      const float s = row[x];
      if (!(s >= options_.min_score)) continue;
      if (!(s > row[x - 1] && s >= row[x + 1] && s > up[x - 1] && s > up[x] && s > up[x + 1] &&
            s >= down[x - 1] && s >= down[x] && s >= down[x + 1])) {
        continue;
      }
      const cv::Point2f at(static_cast<float>(region.x + x) + peakOffset(row[x - 1], s, row[x + 1]),
                           static_cast<float>(region.y + y) + peakOffset(up[x], s, down[x]));
      if (!blocked(at, near_)) candidates_.push_back({at, s, occupancy});
    }
  }
  const auto begin = candidates_.begin() + static_cast<std::ptrdiff_t>(first);
  std::stable_sort(begin, candidates_.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  const bool any = candidates_.size() > first;
  if (candidates_.size() > first + kPerCell) candidates_.resize(first + kPerCell);
  // The second corner of a cell comes after the first corners of all others.
  for (std::size_t i = first; i < candidates_.size(); ++i) {
    candidates_[i].occupancy += static_cast<int>(i - first);
  }
  return any;
}

std::vector<cv::Point2f> CornerDetector::detect(const cv::Mat& gradient,
                                                const std::vector<cv::Point2f>& existing,
                                                int wanted) {
  std::vector<cv::Point2f> chosen;
  const int margin = std::max(options_.border_px, kRadius + 1);
  const cv::Rect inner(margin, margin, gradient.cols - 2 * margin, gradient.rows - 2 * margin);
  if (wanted <= 0 || inner.width <= 0 || inner.height <= 0) return chosen;
  const int nx = (gradient.cols + options_.cell_px - 1) / options_.cell_px;
  const int ny = (gradient.rows + options_.cell_px - 1) / options_.cell_px;
  resting_.resize(static_cast<std::size_t>(nx * ny), 0);
  occupancy_.assign(static_cast<std::size_t>(nx * ny), 0);
  for (const cv::Point2f& p : existing) {
    const int cx = std::clamp(static_cast<int>(p.x) / options_.cell_px, 0, nx - 1);
    const int cy = std::clamp(static_cast<int>(p.y) / options_.cell_px, 0, ny - 1);
    ++occupancy_[static_cast<std::size_t>(cy * nx + cx)];
  }
  // A cell is full when it holds its share of all features there will be.
  const int total = static_cast<int>(existing.size()) + wanted;
  const int share = std::max(1, (total + nx * ny - 1) / (nx * ny));

  candidates_.clear();
  const float reach = static_cast<float>(options_.min_distance_px);
  for (int i = 0; i < nx * ny; ++i) {
    const std::size_t index = static_cast<std::size_t>(i);
    if (resting_[index] > 0) {
      --resting_[index];
      continue;
    }
    if (occupancy_[index] >= share) continue;
    const cv::Rect full((i % nx) * options_.cell_px, (i / nx) * options_.cell_px, options_.cell_px,
                        options_.cell_px);
    const cv::Rect cell = full & inner;
    if (cell.empty()) continue;
    const auto left = static_cast<float>(cell.x), right = static_cast<float>(cell.x + cell.width);
    const auto top = static_cast<float>(cell.y), bottom = static_cast<float>(cell.y + cell.height);
    near_.clear();
    for (const cv::Point2f& p : existing) {
      if (p.x > left - reach && p.x < right + reach && p.y > top - reach && p.y < bottom + reach) {
        near_.push_back(p);
      }
    }
    if (!collectCell(gradient, cell, occupancy_[index])) resting_[index] = kRest;
  }
  std::stable_sort(candidates_.begin(), candidates_.end(),
                   [](const Candidate& a, const Candidate& b) {
                     if (a.occupancy != b.occupancy) return a.occupancy < b.occupancy;
                     return a.score > b.score;
                   });
  for (const Candidate& c : candidates_) {
    if (static_cast<int>(chosen.size()) >= wanted) break;
    if (!blocked(c.at, chosen)) chosen.push_back(c.at);
  }
  return chosen;
}

}  // namespace vir::vision
