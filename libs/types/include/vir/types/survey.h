#pragma once
/// Anchors whose positions somebody has measured, in a frame of their own: the survey's, S, with z
/// up. Where S is in W, a turn about z and an offset, the ranges tell.
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vir/geometry/level_transform.h"

namespace vir {
inline namespace types {

/// As somebody has measured it.
struct SurveyedAnchor {
  std::uint64_t id = 0;
  Vec3 p_S = Vec3::Zero();  ///< [m]
  double sigma_m = 0.05;    ///< of each coordinate, against the other anchors
};

enum class SurveyStatus {
  waiting,       ///< fewer than two of its anchors have been heard, or the ranges are too few
  open,          ///< the ranges fit it in more than one way, or leave it too uncertain
  found,         ///< it lies in W as SurveyFit::T_S_W says
  contradicted,  ///< the ranges do not fit it, however it lies
};
/// As written in summary.json.
const char* name(SurveyStatus status);

/// One anchor of a survey at the end.
struct SurveyedResult {
  SurveyedAnchor given;
  bool heard = false;       ///< there were ranges of it
  bool used = false;        ///< the survey holds it in place
  std::optional<Vec3> p_S;  ///< where the ranges and the survey together put it [m]
};

/// How a survey lies in W, as far as that is known.
struct SurveyFit {
  SurveyStatus status = SurveyStatus::waiting;
  std::string reason;    ///< why it is not `found`; empty if it is
  LevelTransform T_S_W;  ///< p_S = Rz(yaw) p_W + t; only where `found` or something is open
  /// Of (yaw [rad], t [m]).
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  std::vector<std::string> open;        ///< of "yaw", "x", "y", "z": what the ranges cannot decide
  std::vector<SurveyedResult> anchors;  ///< in the order of the survey
  std::vector<std::string> findings;    ///< what is wrong with the survey, a line each
};

}  // namespace types
}  // namespace vir
