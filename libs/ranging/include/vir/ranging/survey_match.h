#pragma once
/// How does a survey of anchors lie in the world of a path? From antenna positions along the path
/// and ranges to the surveyed anchors; and what is wrong with a survey that does not fit.
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "vir/ranging/robust_range.h"
#include "vir/types/survey.h"

namespace vir::ranging {

/// A range to a surveyed anchor, and where the antenna was in W at its time. In order of time.
struct SurveyRange {
  std::size_t anchor = 0;  ///< index in the survey
  Vec3 p_W = Vec3::Zero();
  double range_m = 0;
  double sigma_m = 0.1;  ///< of the range alone
};

struct SurveyMatchOptions {
  int min_ranges = 20;        ///< in all
  double bias_sigma_m = 0.1;  ///< of an anchor's constant bias, mean 0
  /// The same where boards may be uncalibrated; taken where the ranges ask for it. 0: they are not.
  double uncalibrated_bias_sigma_m = 0;
  double drift_ratio = 0.01;  ///< growth of the path's error from its end, metre per metre
  double scale_sigma = 0.02;  ///< of the path's length
  double max_sigma_m = 0.5;   ///< an anchor's place in W may be so uncertain
  double mirror_chi2 = 12;    ///< a second solution worse by more than this is rejected
  bool correlation = true;    ///< let the ranges' autocorrelation widen the covariance
  bool look_for_faults = true;
  /// Faults are looked for although the ranges fit: short paths may fit a wrong survey too.
  bool thorough = false;
  RobustRange robust;
};

enum class SurveyFault {
  exchanged,  ///< two anchors have each other's place: taken as such
  elsewhere,  ///< one is not where the survey has it: not used
  unit,       ///< the numbers are no metres: taken as what they are
};

struct SurveyFinding {
  SurveyFault fault = SurveyFault::elsewhere;
  std::size_t first = 0, second = 0;  ///< indices in the survey
  std::optional<Vec3> found_S;        ///< `elsewhere`: where the ranges put it [m], if they tell
  double factor = 1;                  ///< metres per unit of the survey
  double evidence = 0;                ///< twice the log of the likelihood ratio to no fault
};

/// An anchor of the survey as it would lie in W.
struct MatchedAnchor {
  bool used = false;        ///< false: its entry is wrong, or its ranges do not fit it for now
  Vec3 p_W = Vec3::Zero();  ///< [m]
  double bias_m = 0;        ///< of its ranges
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< position in W, bias [m^2]
};

struct SurveyMatch {
  SurveyStatus status = SurveyStatus::waiting;
  std::string reason;                                    ///< why it is not `found`; empty if it is
  LevelTransform T_S_W;                                  ///< `found` or `open`: the best one
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< of (yaw, t)
  /// A second one, that fits as well but for its height alone (robots on floors): `found` then.
  std::optional<LevelTransform> other;
  std::vector<MatchedAnchor> anchors;  ///< in the order of the survey
  bool uncalibrated = false;           ///< the boards' biases are those of uncalibrated ones
  double needed_sigma_m = 0;           ///< `max_sigma_m` that it would just pass
  std::vector<SurveyFinding> findings;
  std::vector<SurveyedAnchor> survey;  ///< as it is taken, findings applied
};

/// What is wrong, and what is done about it.
std::string describe(const SurveyFinding& finding, const std::vector<SurveyedAnchor>& survey);

/// `survey` with at least two anchors that are heard; others are placed with them. Deterministic;
/// finite for any input; costs some tens of ms.
SurveyMatch matchSurvey(const std::vector<SurveyRange>& ranges,
                        const std::vector<SurveyedAnchor>& survey,
                        const SurveyMatchOptions& options);

}  // namespace vir::ranging
