#include "lens_fit.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "text.h"
#include "vir/camera/camera_model.h"

namespace vir::check {
namespace {

constexpr double kTurned = 0.006;  // [rad] across the axis from image to image, to count
constexpr std::size_t kFewestTurns = 60, kMostTurns = 150, kMostMatches = 40;
constexpr double kNoise = 0.0015;  // of a direction, about half a pixel [rad]
constexpr double kLeastScale = 0.7, kMostScale = 1.42, kMostBend = 0.7;
/// What another lens must leave of the misfit at most, and be better by.
constexpr double kLeft = 0.75, kBetter = 0.05, kWell = 1.0;
/// The same for another model, which moves the rays of the rim by far.
constexpr double kOtherLeft = 0.5, kOtherBetter = 0.25;
constexpr std::size_t kFewestMatches = 12;  // of a turn

struct Turn {
  Mat3 R_C0_C1;
  std::vector<Eigen::Vector4d> matches;
};

Vec3 ray(double x, double y, double scale, double bend) {
  const double factor = (1 + bend * (x * x + y * y)) / scale;
  return Vec3(factor * x, factor * y, 1).normalized();
}

struct RayPair {
  Vec3 before, after;
};

/// Squared distances from the epipolar planes that suit best, of one turn. `noise` [rad].
double misfitOf(const std::vector<RayPair>& rays, const Mat3& R_C0_C1, double noise) {
  Mat3 normals = Mat3::Zero();
  for (const RayPair& r : rays) {
    const Vec3 n = r.before.cross(R_C0_C1 * r.after);
    normals += n * n.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Mat3> eigen;
  eigen.computeDirect(normals, Eigen::EigenvaluesOnly);
  const double mean =
      std::max(0.0, eigen.eigenvalues()(0)) / (noise * noise) / static_cast<double>(rays.size());
  return std::log1p(4 * mean);
}

/// Of all turns, robustly.
double misfit(const std::vector<Turn>& turns, double scale, double bend) {
  double sum = 0;
  for (const Turn& turn : turns) {
    std::vector<RayPair> rays;
    for (const Eigen::Vector4d& m : turn.matches) {
      rays.push_back({ray(m(0), m(1), scale, bend), ray(m(2), m(3), scale, bend)});
    }
    // A pixel is a smaller angle by that much.
    sum += misfitOf(rays, turn.R_C0_C1, kNoise / scale);
  }
  return sum / static_cast<double>(turns.size());
}

/// The model for which the coefficients of this one may be meant; nothing where there is none.
std::optional<CameraCalibration> otherModel(CameraCalibration c) {
  if (c.distortion == Distortion::equidistant) {
    c.distortion = Distortion::radtan;
  } else if (c.distortion == Distortion::radtan && c.dist[4] == 0) {
    c.distortion = Distortion::equidistant;
  } else {
    return std::nullopt;
  }
  return c;
}

/// What both cameras make of the same pixels.
struct BothMisfits {
  double given = 0, other = 0;
  std::size_t turns = 0;
};

BothMisfits compareModels(const std::vector<Turn>& turns, const camera::CameraModel& given,
                          const camera::CameraModel& other) {
  BothMisfits out;
  const auto seen = [&](double x, double y, Vec3* bearing) {
    Vec2 px;
    return given.project(Vec3(x, y, 1), &px) && other.unproject(px, bearing);
  };
  for (const Turn& turn : turns) {
    std::vector<RayPair> as_given, otherwise;
    for (const Eigen::Vector4d& m : turn.matches) {
      RayPair rays;
      if (!seen(m(0), m(1), &rays.before) || !seen(m(2), m(3), &rays.after)) continue;
      otherwise.push_back(rays);
      as_given.push_back({ray(m(0), m(1), 1, 0), ray(m(2), m(3), 1, 0)});
    }
    if (otherwise.size() < kFewestMatches) continue;
    out.given += misfitOf(as_given, turn.R_C0_C1, kNoise);
    out.other += misfitOf(otherwise, turn.R_C0_C1, kNoise);
    ++out.turns;
  }
  const double n = static_cast<double>(std::max<std::size_t>(1, out.turns));
  out.given /= n;
  out.other /= n;
  return out;
}

void lookAtOtherModel(const std::vector<Turn>& turns, const CameraCalibration& given,
                      LensFit* out) {
  const auto other = otherModel(given);
  if (!other) return;
  const BothMisfits both =
      compareModels(turns, *camera::makeCamera(given), *camera::makeCamera(*other));
  out->other = both.other;
  out->other_told = both.turns >= kFewestTurns && both.other < kOtherLeft * both.given &&
                    both.other < both.given - kOtherBetter && both.other < kWell;
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

LensFit fitLens(const std::vector<ImageTurn>& turns_seen, const TurnByGyro& by_gyro,
                const std::optional<CameraCalibration>& camera) {
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
  if (camera) lookAtOtherModel(turns, *camera, &out);
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

Finding otherModelFinding(const LensFit& lens, Distortion given, const std::string& camera_label) {
  const bool radtan = given == Distortion::radtan;
  const std::string is = radtan ? "radtan" : "equidistant";
  const std::string fits = radtan ? "equidistant" : "radtan";
  return {Severity::unusable,
          "camera_lens",
          camera_label,
          "its lens model is given as " + is + ", but the coefficients are those of " + fits,
          "read as " + fits + " they leave " + num(100 * lens.other / lens.as_given, 2) +
              " % of the misfit of gyro and images (" + std::to_string(lens.turns) + " turns)",
          "write " + fits + (radtan ? " (fisheye, KannalaBrandt)" : " (plumb_bob)") +
              " as the model, or calibrate anew"};
}

}  // namespace vir::check
