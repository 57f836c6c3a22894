#pragma once
/// Ranges against a path that is known from elsewhere: unit, clock, constant error, and whether
/// the anchors are where they are said to be.
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "vir/check/finding.h"
#include "vir/check/range_fit.h"
#include "vir/core/thinned_out.h"
#include "vir/types/survey.h"

namespace vir::check {

/// Where anchors are, as far as somebody says so.
struct GivenAnchors {
  std::map<std::uint64_t, Vec3> truth;  ///< in the ground truth's world [m]
  std::vector<SurveyedAnchor> survey;   ///< in a frame of their own
};

/// Of one stream of ranges to anchors. Memory does not grow with the recording.
class RangePathCheck {
 public:
  explicit RangePathCheck(std::string label) : label_(std::move(label)) {}
  void add(const Range& range);
  /// `path`: the ground truth, in order of time.
  std::vector<Finding> againstTruth(const KnownPath& path, const GivenAnchors& anchors) const;
  /// `path`: an odometry, whose scale may be off and which drifts: only what it cannot be the cause
  /// of, from the first minute.
  std::vector<Finding> againstOdometry(const KnownPath& path) const;

 private:
  static constexpr std::size_t kShown = 1500, kMostAnchors = 32;
  std::string label_;
  std::map<std::uint64_t, ThinnedOut<Range>> anchors_;
};

}  // namespace vir::check
