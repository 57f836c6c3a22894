#include "vir/team/find_transform.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "finder.h"

namespace vir::team {
namespace {

/// How much of the positions' standard deviations may be true: estimators are cautious. Where one
/// says 0.3 m of a path that is right to 0.05 m, the likelihood prefers transforms by which the
/// ranges do not feel the error, such as one robot straight above the other.
constexpr double kPositionShares[] = {1, 0.5, 0.25};
constexpr double kSameSigmas = 2;

/// What the evidence says if so much of the standard deviations is true.
struct Reading {
  TransformAnswer answer;
  double cost = std::numeric_limits<double>::infinity();  // of the best transform, not deflated
};

bool exact(const std::vector<MutualRange>& ranges) {
  return std::all_of(ranges.begin(), ranges.end(),
                     [](const MutualRange& m) { return m.cov_A.isZero(0) && m.cov_B.isZero(0); });
}

std::vector<Reading> readAll(const std::vector<MutualRange>& ranges,
                             const std::vector<SharedAnchor>& anchors,
                             const TransformOptions& options,
                             const std::vector<WorldTransform>& hints,
                             const std::optional<SharedPlaces>& places) {
  std::vector<Reading> readings;
  for (const double share : kPositionShares) {
    const Evidence evidence(ranges, anchors, options, share, places);
    std::vector<WorldTransform> all_hints = hints;
    for (const Reading& r : readings) {
      for (const TransformSolution& s : r.answer.solutions) all_hints.push_back(s.T_A_B);
    }
    Reading r;
    r.answer = findAsSaid(evidence, ranges.size(), all_hints);
    if (!r.answer.solutions.empty()) {
      r.cost = r.answer.solutions.front().cost * r.answer.variance_factor;
    }
    readings.push_back(r);
    // Without a solution, or with nothing but exact positions, the other shares say the same.
    if (r.answer.solutions.empty() || exact(evidence.ranges)) break;
  }
  return readings;
}

/// One transform, as far as either knows it.
bool agree(const Evidence& evidence, const TransformAnswer& a, const TransformAnswer& b) {
  const TransformSolution &one = a.solutions.front(), &other = b.solutions.front();
  Vec4 level = toVector(other.T_A_B);
  if (a.height_open || b.height_open) level[3] = one.T_A_B.t_m.z();
  const auto known = [](const TransformSolution& s) {
    return kSameSigmas * std::sqrt(std::max(0.0, s.covariance(1, 1) + s.covariance(2, 2)));
  };
  return evidence.apart(toVector(one.T_A_B), level) <
         std::max({evidence.options.same_solution_m, known(one), known(other)});
}

TransformAnswer contradiction(const TransformAnswer& likeliest, const TransformAnswer& other) {
  TransformAnswer out = likeliest;
  out.status = TransformStatus::ambiguous;
  out.margin = 0;
  out.reason = "two transforms fit, depending on how certain both robots' own positions are";
  out.solutions.push_back(other.solutions.front());
  return out;
}

/// Unique is what is so by all that may be true, as uncertain as it may be.
TransformAnswer agreed(const Evidence& evidence, const std::vector<Reading>& readings) {
  const Reading& likeliest =
      *std::min_element(readings.begin(), readings.end(),
                        [](const Reading& a, const Reading& b) { return a.cost < b.cost; });
  const TransformAnswer* told = nullptr;
  double margin = std::numeric_limits<double>::infinity();
  for (const Reading& r : readings) {
    const double above = r.cost - likeliest.cost;
    const double needed = r.answer.needed_margin *
                          std::max(r.answer.variance_factor, likeliest.answer.variance_factor);
    if (!(above <= needed)) continue;
    if (r.answer.status != TransformStatus::unique) return r.answer;
    if (!agree(evidence, r.answer, likeliest.answer)) {
      return contradiction(likeliest.answer, r.answer);
    }
    margin = std::min(margin, r.answer.margin);
    if (told == nullptr) told = &r.answer;  // the most cautious
  }
  // Doubt about the standard deviations is for the verdict. Where they lead to the same transform
  // as the likeliest reading, what they say is told: its height and covariance are the cautious
  // ones (ranges that are believed ten times more pull an unknown height off the middle).
  const TransformAnswer& as_said = readings.front().answer;
  if (as_said.status == TransformStatus::unique && agree(evidence, as_said, likeliest.answer)) {
    told = &as_said;
    margin = std::min(margin, as_said.margin);
  }
  if (told == nullptr) return readings.front().answer;  // costs that are no numbers
  TransformAnswer out = *told;
  out.margin = margin;
  return out;
}

}  // namespace

TransformAnswer findTransform(const std::vector<MutualRange>& ranges,
                              const std::vector<SharedAnchor>& anchors,
                              const TransformOptions& options,
                              const std::vector<WorldTransform>& hints,
                              const std::optional<SharedPlaces>& places) {
  options.validate();
  const std::vector<Reading> readings = readAll(ranges, anchors, options, hints, places);
  if (readings.size() == 1) return readings.front().answer;
  return agreed(Evidence(ranges, anchors, options, 1, places), readings);
}

}  // namespace vir::team
