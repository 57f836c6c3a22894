#pragma once
/// Focal length and lens against the gyro: which rays are such that epipolar lines meet with the
/// rotation that the gyro says.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "vir/check/finding.h"
#include "vir/check/turning.h"
#include "vir/types/calibration.h"

namespace vir::check {

struct LensFit {
  bool told = false;  ///< others fit clearly better than those given, and well
  /// Rays as they are = rays as given (x, y at depth 1) * (1 + bend r^2) / scale.
  double scale = 1, bend = 0;
  double as_given = 0, best = 0;  ///< mean of the robust misfit over turns
  int turns = 0;
  /// The same coefficients in the other model are clearly better: radtan and equidistant exchanged.
  bool other_told = false;
  double other = 0;  ///< misfit with that
};

/// Rotation of a turn by the gyro, R_C0_C1, its bias taken off; nothing where there are no
/// readings.
using TurnByGyro = std::function<std::optional<Mat3>(const ImageTurn&)>;

/// From turns that have their matches, seen through `camera` where that is known; the direction of
/// motion is free in each.
LensFit fitLens(const std::vector<ImageTurn>& turns, const TurnByGyro& by_gyro,
                const std::optional<CameraCalibration>& camera);

/// Of a fit whose `other_told` holds.
Finding otherModelFinding(const LensFit& lens, Distortion given, const std::string& camera_label);

}  // namespace vir::check
