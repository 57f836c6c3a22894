#include "patch.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace vir::vision {

namespace {
// Grey levels per pixel of the patch: below it there is only noise to align.
constexpr float kMinDeviation = 2.0f;
// Pulls the affine part towards its prediction; relative to the information on it.
constexpr double kAffineDamping = 0.05;
// Variance of the noise of one image [grey levels^2]: a good sensor in fair light.
constexpr float kNoiseVariance = 4.0f;
constexpr double kConverged = 0.01;  // [px] a step this small is the last
constexpr double kSettled = 0.1;     // [px] a last step larger than this has not converged
}  // namespace

bool Patch::take(const cv::Mat& image, const Vec2& px, int half) {
  half_ = 0;
  const int cx = static_cast<int>(std::lround(px.x()));
  const int cy = static_cast<int>(std::lround(px.y()));
  if (cx - half - 1 < 0 || cy - half - 1 < 0 || cx + half + 1 >= image.cols ||
      cy + half + 1 >= image.rows) {
    return false;
  }
  const int side = 2 * half + 1;
  values_.resize(side * side);
  jacobian_.resize(side * side, 8);
  int i = 0;
  for (int y = -half; y <= half; ++y) {
    const uchar* up = image.ptr<uchar>(cy + y - 1) + cx;
    const uchar* row = image.ptr<uchar>(cy + y) + cx;
    const uchar* down = image.ptr<uchar>(cy + y + 1) + cx;
    for (int x = -half; x <= half; ++x, ++i) {
      values_[i] = row[x];
      const float gx = 0.5f * (static_cast<float>(row[x + 1]) - static_cast<float>(row[x - 1]));
      const float gy = 0.5f * (static_cast<float>(down[x]) - static_cast<float>(up[x]));
      const float fx = static_cast<float>(x), fy = static_cast<float>(y);
      jacobian_.row(i) << gx, gy, gx * fx, gx * fy, gy * fx, gy * fy, 0.0f, 1.0f;
    }
  }
  values_.array() -= values_.mean();
  const float norm = values_.norm();
  if (!(norm > kMinDeviation * static_cast<float>(side))) return false;
  norm_ = norm;
  jacobian_.col(6) = values_;
  Eigen::Matrix<double, 8, 8> H = (jacobian_.transpose() * jacobian_).cast<double>();
  for (int k = 2; k < 6; ++k) H(k, k) *= 1.0 + kAffineDamping;
  inverse_ = H.inverse();
  if (!inverse_.allFinite()) return false;
  half_ = half;
  centre_ = Vec2(cx, cy);
  offset_ = px - centre_;
  return true;
}

bool Patch::sample(const cv::Mat& image, const PatchWarp& warp, Eigen::VectorXf* values) const {
  const Eigen::Matrix2f A = warp.A.cast<float>();
  const Eigen::Vector2f c = warp.c.cast<float>();
  const float h = static_cast<float>(half_);
  const float reach_x = h * (std::abs(A(0, 0)) + std::abs(A(0, 1)));
  const float reach_y = h * (std::abs(A(1, 0)) + std::abs(A(1, 1)));
  // Written so that a NaN is outside.
  if (!(c.x() - reach_x >= 0.0f && c.y() - reach_y >= 0.0f &&
        c.x() + reach_x < static_cast<float>(image.cols - 1) &&
        c.y() + reach_y < static_cast<float>(image.rows - 1))) {
    return false;
  }
  const std::size_t step = image.step;
  float* out = values->data();
  const int side = 2 * half_ + 1;
  // One row at a time in short loops of one kind each: all but the gathering then vectorise.
  constexpr int kMaxSide = 64;
  float du[kMaxSide], dv[kMaxSide], top_left[kMaxSide], top_right[kMaxSide], low_left[kMaxSide],
      low_right[kMaxSide];
  int iu[kMaxSide], iv[kMaxSide];
  for (int y = -half_; y <= half_; ++y, out += side) {
    const float bx = A(0, 1) * static_cast<float>(y) + c.x();
    const float by = A(1, 1) * static_cast<float>(y) + c.y();
    for (int i = 0; i < side; ++i) {
      const float x = static_cast<float>(i - half_);
      const float u = A(0, 0) * x + bx;
      const float v = A(1, 0) * x + by;
      iu[i] = static_cast<int>(u);
      iv[i] = static_cast<int>(v);
      du[i] = u - static_cast<float>(iu[i]);
      dv[i] = v - static_cast<float>(iv[i]);
    }
    for (int i = 0; i < side; ++i) {
      const uchar* p = image.data + static_cast<std::size_t>(iv[i]) * step + iu[i];
      top_left[i] = p[0];
      top_right[i] = p[1];
      low_left[i] = p[step];
      low_right[i] = p[step + 1];
    }
    for (int i = 0; i < side; ++i) {
      const float top = top_left[i] + du[i] * (top_right[i] - top_left[i]);
      const float low = low_left[i] + du[i] * (low_right[i] - low_left[i]);
      out[i] = top + dv[i] * (low - top);
    }
  }
  return true;
}

bool Patch::align(const cv::Mat& image, const AlignOptions& options, PatchWarp* warp) const {
  if (empty()) return false;
  const Vec2 start = warp->c;
  // A hundred patches per image, some iterations each: memory is kept, one for each thread.
  thread_local Eigen::VectorXf now, difference;
  now.resize(values_.size());
  double last_step = 0.0;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    if (!sample(image, *warp, &now)) return false;
    now.array() -= now.mean();
    const float norm = now.norm();
    if (!(norm > 1.0f)) return false;
    now *= norm_ / norm;
    difference = now - values_;
    const Eigen::Matrix<double, 8, 1> g = (jacobian_.transpose() * difference).cast<double>();
    const Eigen::Matrix<double, 8, 1> d = inverse_ * g;
    Eigen::Matrix2d delta;
    delta << 1.0 + d[2], d[3], d[4], 1.0 + d[5];
    const double area = delta.determinant();
    if (!(area > 0.25 && area < 4.0)) return false;
    warp->A = warp->A * delta.inverse();
    warp->c -= warp->A * d.head<2>();
    if (!((warp->c - start).norm() < options.max_shift_px)) return false;
    // The affine part moves the rim of the patch: it must settle as well, but less exactly.
    last_step = std::max(d.head<2>().norm(), 0.1 * half_ * d.segment<4>(2).norm());
    if (last_step < kConverged) break;
  }
  if (!(last_step < kSettled)) return false;
  // `now` has the patch's contrast. Noise of both images alone lowers the correlation of a weak
  // patch: allowed for.
  const float n = static_cast<float>(values_.size());
  const float similarity = now.dot(values_) / (norm_ * norm_);
  const float allowance = kNoiseVariance * n / (norm_ * norm_);
  return similarity > static_cast<float>(options.min_similarity) - std::min(allowance, 0.2f);
}

}  // namespace vir::vision
