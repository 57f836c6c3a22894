#include "lens_fit.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace vir::check {
namespace {

constexpr double kTurned = 0.006;  // [rad] across the axis from image to image, to count
constexpr std::size_t kFewestTurns = 60, kMostTurns = 150, kMostMatches = 40;
constexpr double kNoise = 0.0015;  // of a direction, about half a pixel [rad]
constexpr double kLeastScale = 0.7, kMostScale = 1.42, kMostBend = 0.7;
/// What another lens must leave of the misfit at most, and be better by.
constexpr double kLeft = 0.75, kBetter = 0.05, kWell = 1.0;

struct Turn {
  Mat3 R_C0_C1;
  std::vector<Eigen::Vector4d> matches;
};

Vec3 ray(double x, double y, double scale, double bend) {
  const double factor = (1 + bend * (x * x + y * y)) / scale;
  return Vec3(factor * x, factor * y, 1).normalized();
}

/// Squared distances from epipolar planes that suit best, robustly over turns.
double misfit(const std::vector<Turn>& turns, double scale, double bend) {
  double sum = 0;
  for (const Turn& turn : turns) {
    Mat3 normals = Mat3::Zero();
    for (const Eigen::Vector4d& m : turn.matches) {
      const Vec3 n =
          ray(m(0), m(1), scale, bend).cross(turn.R_C0_C1 * ray(m(2), m(3), scale, bend));
      normals += n * n.transpose();
    }
    Eigen::SelfAdjointEigenSolver<Mat3> eigen;
    eigen.computeDirect(normals, Eigen::EigenvaluesOnly);
    // A pixel is a smaller angle by that much.
    const double noise = kNoise / scale;
    const double mean = std::max(0.0, eigen.eigenvalues()(0)) / (noise * noise) /
                        static_cast<double>(turn.matches.size());
    sum += std::log1p(4 * mean);
  }
  return sum / static_cast<double>(turns.size());
}

/// Some of all, evenly.
template <typename Item>
std::vector<Item> thinned(const std::vector<Item>& all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<Item> out;
  for (std::size_t i = 0; i < most; ++i) out.push_back(all[i * all.size() / most]);
  return out;
}

}  // namespace

LensFit fitLens(const std::vector<ImageTurn>& turns_seen, const TurnByGyro& by_gyro) {
  std::vector<Turn> turns;
  for (const ImageTurn& seen : turns_seen) {
    if (seen.matches.empty()) continue;
    const auto R = by_gyro(seen);
    // About the axis no scale shows.
    if (!R || logSO3(*R).head<2>().norm() < kTurned) continue;
    Turn turn{*R, {}};
    for (const Eigen::Vector4f& m : thinned(seen.matches, kMostMatches)) {
      turn.matches.push_back(m.cast<double>());
    }
    turns.push_back(std::move(turn));
  }
  LensFit out;
  if (turns.size() < kFewestTurns) return out;
  turns = thinned(turns, kMostTurns);
  out.turns = static_cast<int>(turns.size());
  out.as_given = out.best = misfit(turns, 1, 0);
  const auto look = [&](double scale, double bend) {
    if (scale < kLeastScale || scale > kMostScale || std::abs(bend) > kMostBend) return;
    const double here = misfit(turns, scale, bend);
    if (here >= out.best) return;
    out.best = here;
    out.scale = scale;
    out.bend = bend;
  };
  for (double scale = kLeastScale; scale < kMostScale + 1e-9; scale += 0.09) {
    for (double bend = -0.6; bend < 0.6 + 1e-9; bend += 0.15) look(scale, bend);
  }
  for (double step = 0.5; step > 0.1; step /= 2) {
    const double scale = out.scale, bend = out.bend;
    for (const int i : {-1, 0, 1}) {
      for (const int k : {-1, 0, 1}) look(scale + 0.09 * step * i, bend + 0.15 * step * k);
    }
  }
  const bool inside = out.scale > kLeastScale + 0.03 && out.scale < kMostScale - 0.03;
  out.told = inside && out.best < kLeft * out.as_given && out.best < out.as_given - kBetter &&
             out.best < kWell;
  return out;
}

}  // namespace vir::check
