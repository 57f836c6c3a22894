#include "epipolar_search.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tracker_impl.h"

namespace vir::vision {
namespace {

/// Edge of what is compared, at half the resolution [px]: from -kHalf to kHalf - 1.
constexpr int kHalf = 4;
constexpr int kSide = 2 * kHalf, kArea = kSide * kSide;
/// Nothing is expected nearer than so many baselines, within these bounds [m].
constexpr double kNearestBaselines = 3, kNearestLeast = 0.2, kNearestMost = 1.0;
constexpr int kMostSamples = 600;
/// Correlation that the best must have, and by how much less the second may lack of one.
constexpr float kLeastCorrelation = 0.7f, kClearly = 0.75f;
/// What is nearer to the best along the curve is the best itself [px of the half resolution].
constexpr double kSamePeakPx = 3;
/// Searched back, so near to where it began [px].
constexpr double kBackPx = 2.5;

struct Sample {
  Vec2 px;            ///< of the full resolution
  Vec2 along;         ///< unit, in the image
  Eigen::Matrix2d A;  ///< neighbourhood in `from` to the one here
};

/// Grey levels about a pixel, as they would look in the other camera; their mean taken off.
struct Template {
  std::array<std::int16_t, kArea> values;
  int sum = 0;  ///< what rounding left
  float norm = 0;
};

float greyAt(const cv::Mat& image, double x, double y) {
  const int iu = static_cast<int>(x), iv = static_cast<int>(y);
  const auto a = static_cast<float>(x - iu), b = static_cast<float>(y - iv);
  const uchar* top = image.ptr<uchar>(iv) + iu;
  const uchar* low = image.ptr<uchar>(iv + 1) + iu;
  const float t = static_cast<float>(top[0]) + a * (static_cast<float>(top[1]) - top[0]);
  const float l = static_cast<float>(low[0]) + a * (static_cast<float>(low[1]) - low[0]);
  return t + b * (l - t);
}

/// `A`: from `image` to where it is looked for.
bool makeTemplate(const cv::Mat& image, const Vec2& px, const Eigen::Matrix2d& A, Template* out) {
  const Eigen::Matrix2d back = A.inverse();
  if (!back.allFinite()) return false;
  const Vec2 centre = 0.5 * px;
  const double reach = kHalf * back.cwiseAbs().rowwise().sum().maxCoeff();
  if (!(reach < 40) ||
      !(centre.x() - reach >= 0 && centre.y() - reach >= 0 && centre.x() + reach < image.cols - 1 &&
        centre.y() + reach < image.rows - 1)) {
    return false;
  }
  std::array<float, kArea> grey;
  float mean = 0;
  std::size_t k = 0;
  for (int y = -kHalf; y < kHalf; ++y) {
    for (int x = -kHalf; x < kHalf; ++x, ++k) {
      const Vec2 at = centre + back * Vec2(x, y);
      grey[k] = greyAt(image, at.x(), at.y());
      mean += grey[k] / kArea;
    }
  }
  // Finer than grey levels, and small enough for sums of whole numbers.
  constexpr float kFiner = 16;
  int squares = 0;
  out->sum = 0;
  for (k = 0; k < kArea; ++k) {
    const auto v = static_cast<std::int16_t>(std::lround(kFiner * (grey[k] - mean)));
    out->values[k] = v;
    out->sum += v;
    squares += v * v;
  }
  out->norm = std::sqrt(static_cast<float>(squares));
  return out->norm > 1.5f * kFiner * kSide;  // else there is only noise to compare
}

float correlation(const Template& t, const cv::Mat& image, int cx, int cy) {
  int cross = 0, sum = 0, squares = 0;
  const std::int16_t* v = t.values.data();
  for (int y = -kHalf; y < kHalf; ++y, v += kSide) {
    const uchar* row = image.ptr<uchar>(cy + y) + cx - kHalf;
    for (int x = 0; x < kSide; ++x) {
      const auto g = static_cast<std::int16_t>(row[x]);
      cross += v[x] * g;
      sum += g;
      squares += g * g;
    }
  }
  const float mean = static_cast<float>(sum) / kArea;
  const float variance = static_cast<float>(squares) - static_cast<float>(sum) * mean;
  const float common = static_cast<float>(cross) - static_cast<float>(t.sum) * mean;
  return variance > 1.0f * kArea ? common / (t.norm * std::sqrt(variance)) : 0.0f;
}

bool insideHalf(const cv::Mat& image, int x, int y) {
  return x >= kHalf && y >= kHalf && x + kHalf < image.cols && y + kHalf < image.rows;
}

/// Along the curve from infinity to the nearest, about a pixel of the half resolution apart.
std::vector<Sample> curveOf(const EpipolarView& from, const Vec2& px, const EpipolarView& to,
                            const Pose& T_to_from, double most_inverse_m) {
  std::vector<Sample> out;
  Vec3 bearing;
  Vec2 again;
  Mat23 J_from;
  if (!from.camera->unproject(px, &bearing) || !from.camera->project(bearing, &again, &J_from)) {
    return out;
  }
  const Mat3 R = T_to_from.R();
  const Eigen::Matrix<double, 3, 2> by_px =
      J_from.transpose() * (J_from * J_from.transpose()).inverse();
  const Vec3 far = R * bearing;
  const double nearest =
      std::clamp(kNearestBaselines * T_to_from.p.norm(), kNearestLeast, kNearestMost);
  const double last = most_inverse_m > 0 ? std::min(most_inverse_m, 1 / nearest) : 1 / nearest;
  double rho = 0;
  for (int k = 0; k < kMostSamples && rho <= last; ++k) {
    const Vec3 p = far + rho * T_to_from.p;
    Sample s;
    Mat23 J;
    if (!to.camera->project(p, &s.px, &J)) {
      rho += last / 64;
      continue;
    }
    const Vec2 way = J * T_to_from.p;
    const double speed = way.norm();
    s.along = speed > 1e-9 ? Vec2(way / speed) : Vec2(Vec2::UnitX());
    s.A = J * R * by_px;
    out.push_back(s);
    rho += speed > 1e-9 ? std::min(2.0 / speed, last / 4) : last;
  }
  return out;
}

struct Peak {
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity();  ///< see Sample
  Vec2 half_px = Vec2::Zero();
  float value = 0;
};

/// To the top nearby, between the pixels: what is aligned from a pixel off may end anywhere.
void climb(const Template& t, const cv::Mat& image, Peak* peak) {
  constexpr int kSteps = 3;
  int x = static_cast<int>(std::lround(peak->half_px.x()));
  int y = static_cast<int>(std::lround(peak->half_px.y()));
  const auto at = [&](int dx, int dy) {
    return insideHalf(image, x + dx, y + dy) ? correlation(t, image, x + dx, y + dy) : 0.0f;
  };
  float middle = at(0, 0);
  for (int step = 0; step < kSteps; ++step) {
    int best_x = 0, best_y = 0;
    float best = middle;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const float c = at(dx, dy);
        if (c > best) {
          best = c;
          best_x = dx;
          best_y = dy;
        }
      }
    }
    if (best_x == 0 && best_y == 0) break;
    x += best_x;
    y += best_y;
    middle = best;
  }
  const auto top = [middle](float before, float after) {
    const float curvature = before - 2 * middle + after;
    if (!(curvature < 0)) return 0.0;
    return static_cast<double>(std::clamp(0.5f * (before - after) / curvature, -0.5f, 0.5f));
  };
  peak->half_px = Vec2(x + top(at(-1, 0), at(1, 0)), y + top(at(0, -1), at(0, 1)));
  peak->value = middle;
}

/// The best along the curve if it is clearly that.
std::optional<Peak> searchCurve(const cv::Mat& from, const Vec2& px, const cv::Mat& to,
                                const std::vector<Sample>& curve, double band_px) {
  constexpr std::size_t kPerTemplate = 16;
  const int band = static_cast<int>(std::ceil(0.5 * band_px));
  std::vector<Peak> peaks;  // the best across the curve, for each sample
  Template t;
  bool any = false;
  for (std::size_t k = 0; k < curve.size(); ++k) {
    const Sample& s = curve[k];
    if (k % kPerTemplate == 0) {
      const std::size_t middle = std::min(k + kPerTemplate / 2, curve.size() - 1);
      any = makeTemplate(from, px, curve[middle].A, &t);
    }
    if (!any) continue;
    Peak best{s.A, Vec2::Zero(), -1};
    for (int i = -band; i <= band; ++i) {
      const Vec2 at = 0.5 * s.px + i * Vec2(-s.along.y(), s.along.x());
      const int x = static_cast<int>(std::lround(at.x())),
                y = static_cast<int>(std::lround(at.y()));
      if (!insideHalf(to, x, y)) continue;
      const float c = correlation(t, to, x, y);
      if (c > best.value) best = {s.A, Vec2(x, y), c};
    }
    if (best.value > 0) peaks.push_back(best);
  }
  const auto best = std::max_element(
      peaks.begin(), peaks.end(), [](const Peak& a, const Peak& b) { return a.value < b.value; });
  if (best == peaks.end() || best->value < kLeastCorrelation) return std::nullopt;
  for (const Peak& p : peaks) {
    if ((p.half_px - best->half_px).norm() <= kSamePeakPx) continue;
    if (1 - best->value > kClearly * (1 - p.value)) return std::nullopt;
  }
  Peak out = *best;
  if (!makeTemplate(from, px, out.A, &t)) return std::nullopt;
  climb(t, to, &out);
  return out;
}

}  // namespace

double besideCurvePx(const Pose& T_b_a, const Vec3& a, const Vec3& b, const Mat23& dpx_db) {
  const Vec3 normal = T_b_a.p.cross(T_b_a.q * a);
  const double length = normal.norm();
  if (length < 1e-9) return 0;
  // Off the plane by that angle, along the normal.
  const Vec3 n = normal / length;
  return n.dot(b) * (dpx_db * n).norm();
}

std::optional<Vec2> matchAlongCurve(const EpipolarView& from, const Vec2& px,
                                    const EpipolarView& to, const Pose& T_to_from,
                                    const EpipolarOptions& options) {
  const cv::Mat& half_from = from.image->halvings().front();
  const cv::Mat& half_to = to.image->halvings().front();
  const auto found =
      searchCurve(half_from, px, half_to, curveOf(from, px, to, T_to_from, options.most_inverse_m),
                  options.band_px);
  if (!found) return std::nullopt;
  Patch patch;
  if (!patch.take(from.image->full(), px, options.patch_px / 2)) return std::nullopt;
  PatchWarp warp{found->A, Vec2::Zero()};
  warp.c = 2 * found->half_px - patch.feature(warp);
  const AlignOptions align{options.max_iterations, 4.0, options.min_similarity};
  if (!patch.align(to.image->full(), align, &warp)) return std::nullopt;
  const Vec2 at = patch.feature(warp);
  const auto back = searchCurve(half_to, at, half_from,
                                curveOf(to, at, from, T_to_from.inverse(), options.most_inverse_m),
                                options.band_px);
  if (!back || (2 * back->half_px - px).norm() > kBackPx) return std::nullopt;
  return at;
}

double inverseDistance(const Pose& T_b_a, const Vec3& a, const Vec3& b) {
  // Across b: R a + rho t has nothing there.
  const Vec3 u = (T_b_a.q * a).cross(b), v = T_b_a.p.cross(b);
  const double squares = v.squaredNorm();
  return squares > 1e-18 ? std::max(0.0, -u.dot(v) / squares) : 0;
}

double overlapOf(const camera::CameraModel& a, const camera::CameraModel& b, const Pose& T_b_a) {
  constexpr int kColumns = 8, kRows = 6;
  constexpr double kDistance = 4;
  const CameraCalibration &ca = a.calibration(), &cb = b.calibration();
  int seen = 0;
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const Vec2 px((x + 0.5) * ca.width / kColumns, (y + 0.5) * ca.height / kRows);
      Vec3 bearing;
      Vec2 there;
      if (!a.unproject(px, &bearing) || !b.project(T_b_a * Vec3(kDistance * bearing), &there)) {
        continue;
      }
      seen += there.x() >= 0 && there.y() >= 0 && there.x() < cb.width && there.y() < cb.height;
    }
  }
  return static_cast<double>(seen) / (kColumns * kRows);
}

}  // namespace vir::vision
