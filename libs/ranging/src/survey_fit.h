#pragma once
/// Internal: least squares for the place of a survey, the path and the anchors' biases in it.
#include <Eigen/Core>
#include <vector>

#include "range_fit.h"
#include "vir/ranging/survey_match.h"

namespace vir::ranging {

/// Turn of the path in S, where its newest end is there, and the log of the factor by which it is
/// too short, seen from that end; per anchor, how far it is off its surveyed place [m], and the
/// bias of its ranges [m].
struct SurveyState {
  double yaw = 0;
  Vec3 end_S = Vec3::Zero();
  double log_scale = 0;
  std::vector<Vec4> anchors;
};

/// Ranges with what the fit makes of them.
struct SurveyData {
  std::vector<SurveyRange> ranges;  ///< sigma includes the path's drift
  std::vector<double> drift;        ///< of the path from here to its end [m]
  Vec3 end_W = Vec3::Zero();        ///< newest antenna position
  /// At most `count` of each anchor, evenly spread.
  SurveyData thinned(std::size_t count) const;
};

class SurveyFitter {
 public:
  SurveyFitter(const SurveyData* data, const std::vector<SurveyedAnchor>* survey,
               const SurveyMatchOptions* options)
      : data_(data), survey_(survey), options_(options) {}

  /// As RangeFit::setFactors.
  void setFactors(double scale, double worth) { scale_ = scale, worth_ = worth; }
  double cost(const SurveyState& x) const;
  SurveyState minimise(SurveyState x, int iterations, double* cost) const;
  /// (measured - predicted) / sigma as claimed, per range.
  std::vector<double> residuals(const SurveyState& x) const;
  SurveyState startAt(double yaw, const Vec3& end_S) const;
  /// Covariance of (yaw, end in S).
  Eigen::Matrix4d covariance(const SurveyState& x) const;

 private:
  struct AnchorPart {
    Mat4 H = Mat4::Zero();
    Eigen::Matrix<double, 5, 4> cross = Eigen::Matrix<double, 5, 4>::Zero();
    Vec4 g = Vec4::Zero();
  };
  /// Normal equations: what is common to all anchors, and each anchor's own.
  struct System {
    Mat5 H = Mat5::Zero();
    Vec5 g = Vec5::Zero();
    std::vector<AnchorPart> anchors;
  };
  double build(const SurveyState& x, System* system) const;
  SurveyState step(const SurveyState& x, const System& system, double damping) const;

  const SurveyData* data_;
  const std::vector<SurveyedAnchor>* survey_;
  const SurveyMatchOptions* options_;
  double scale_ = 1, worth_ = 1;
};

}  // namespace vir::ranging
