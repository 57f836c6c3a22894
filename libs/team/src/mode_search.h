#pragma once
/// The transforms that the evidence may mean: minima of its cost.
#include <optional>
#include <vector>

#include "evidence_cost.h"

namespace vir::team {

/// What can be used of what came in, ranges in order of time.
struct Evidence {
  Evidence(const std::vector<MutualRange>& all_ranges, const std::vector<SharedAnchor>& all_anchors,
           const TransformOptions& how, double share_of_positions = 1,
           const std::optional<SharedPlaces>& shared_places = {});

  /// How far apart two transforms place B's path [m].
  double apart(const Vec4& a, const Vec4& b) const;
  /// Of B's path, in its world, and its root mean square extent.
  Vec3 middleOfB() const;
  double spreadOfB() const;
  EvidenceCost cost() const { return {ranges, anchors, options, position_share, places}; }
  /// Of some of the ranges, or by other options.
  EvidenceCost cost(const std::vector<MutualRange>& some, const TransformOptions& how) const {
    return {some, anchors, how, position_share, places};
  }

  std::vector<MutualRange> ranges;
  std::vector<SharedAnchor> anchors;
  const TransformOptions& options;
  double position_share;  ///< as of EvidenceCost
  std::optional<SharedPlaces> places;
};

/// How many ranges a transform explains.
struct Fit {
  int used = 0, rejected = 0, too_short = 0;
};
Fit fitOf(const std::vector<Innovation>& innovations, const TransformOptions& options);
bool plausible(const Fit& fit, const TransformOptions& options);

struct Mode {
  double cost = 0;
  Vec4 x = Vec4::Zero();
};

constexpr std::size_t kMostModes = 4;
constexpr double kExact = 1e-12;  // change of the cost that ends a refinement
/// A standard deviation above which it is not taken as given [m].
constexpr double kLookedAt = 0.1;

/// Where the places that both have seen put B, and the common anchors. `evidence` must have places.
Mode byPlaces(const Evidence& evidence);
/// By how much less likely it is that these places only look alike, whatever the transform is then.
double marginOfPlaces(const EvidenceCost& cost, const Vec4& x);

/// Best first; empty if there is nothing to start from. Modes that are worse than the best by much
/// more than `needed_margin` are left out.
std::vector<Mode> searchModes(const Evidence& evidence, const std::vector<WorldTransform>& hints,
                              double needed_margin);

}  // namespace vir::team
