#include "vir/check/difference_check.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "text.h"
#include "vir/core/order_statistics.h"

namespace vir::check {
namespace {

constexpr const char* kStream = "TDOA";
constexpr std::size_t kKept = 5000;      // values per pair
constexpr std::size_t kPairs = 1024;     // more are bit errors
constexpr double kFarthest = 300;        // [m] that such a radio reaches
constexpr long kEnough = 50;             // differences of a pair to say a word of it
constexpr double kSigmas = 5, kM = 0.5;  // beyond what two anchors are apart
constexpr double kShare = 0.05;          // of those of a pair

std::string nameOf(const std::pair<std::uint64_t, std::uint64_t>& pair) {
  return "anchor " + std::to_string(pair.second) + " less anchor " + std::to_string(pair.first);
}

/// How far two anchors are apart, if both are in one of the two frames.
std::optional<double> distanceOf(const std::pair<std::uint64_t, std::uint64_t>& pair,
                                 const GivenAnchors& given) {
  std::map<std::uint64_t, Vec3> surveyed;
  for (const SurveyedAnchor& s : given.survey) surveyed[s.id] = s.p_S;
  for (const std::map<std::uint64_t, Vec3>* places : {&given.truth, &std::as_const(surveyed)}) {
    const auto a = places->find(pair.first), b = places->find(pair.second);
    if (a != places->end() && b != places->end()) return (a->second - b->second).norm();
  }
  return std::nullopt;
}

}  // namespace

void DifferenceCheck::add(const Range& d) {
  ++count_;
  sigma_m_ = d.sigma_m;
  if (!std::isfinite(d.range_m) || !d.reference || *d.reference == d.anchor) {
    ++none_;
    return;
  }
  const std::pair<std::uint64_t, std::uint64_t> which{*d.reference, d.anchor};
  if (pairs_.count(which) == 0 && pairs_.size() >= kPairs) {
    ++other_pairs_;
    return;
  }
  Pair& pair = pairs_[which];
  if (pair.count > 0 && d.range_m == pair.last) ++pair.stuck;
  if (pair.values.size() < kKept) pair.values.push_back(d.range_m);
  pair.last = d.range_m;
  ++pair.count;
}

void DifferenceCheck::checkPlaces(const GivenAnchors& given, std::vector<Finding>* out) const {
  for (const auto& [which, pair] : pairs_) {
    const auto between = distanceOf(which, given);
    if (!between || pair.count < kEnough) continue;
    const double apart = *between;
    const double limit = apart + std::max(kM, kSigmas * sigma_m_);
    const auto beyond = std::count_if(pair.values.begin(), pair.values.end(),
                                      [&](double v) { return std::abs(v) > limit; });
    if (static_cast<double>(beyond) < kShare * static_cast<double>(pair.values.size())) continue;
    out->push_back({Severity::doubtful, "difference_impossible", kStream,
                    nameOf(which) + " is more than the two are apart",
                    std::to_string(beyond) + " of " + std::to_string(pair.values.size()) +
                        " are beyond the " + num(apart, 4) + " m between them",
                    "are the anchors' places and numbers right, and the differences in metres?"});
  }
}

std::vector<Finding> DifferenceCheck::findings(const GivenAnchors& places) const {
  std::vector<Finding> out;
  if (count_ == 0) return out;
  if (none_ > count_ / 10) {
    out.push_back({none_ == count_ ? Severity::unusable : Severity::doubtful,
                   "differences_unusable", kStream,
                   "differences of ranges are no numbers, or of an anchor to itself",
                   std::to_string(none_) + " of " + std::to_string(count_),
                   "leave out what the radio reports as failed"});
  }
  std::set<std::uint64_t> anchors;
  std::vector<double> sizes;
  for (const auto& [which, pair] : pairs_) {
    anchors.insert({which.first, which.second});
    for (const double v : pair.values) sizes.push_back(std::abs(v));
    if (pair.count >= kEnough && pair.stuck > pair.count / 2) {
      out.push_back({Severity::note, "differences_repeat", kStream,
                     nameOf(which) + " mostly repeats",
                     std::to_string(pair.stuck) + " of " + std::to_string(pair.count), ""});
    }
  }
  const double typical = medianInPlace(&sizes);
  if (typical > kFarthest) {
    out.push_back({Severity::unusable, "differences_in_mm", kStream,
                   "the differences of ranges are not in metres", "median size " + num(typical, 4),
                   "name their unit: unit=mm in --topic range= of a bag, `tdoa [mm]` in a table"});
    return out;
  }
  checkPlaces(places, &out);
  out.push_back({Severity::note, "differences", kStream,
                 "differences of ranges (TDoA) need their anchors' places",
                 std::to_string(count_) + " of " + std::to_string(pairs_.size()) + " pairs, " +
                     std::to_string(anchors.size()) + " anchors",
                 "run with --anchors anchors.csv (id,x,y,z,sigma), three anchors at least"});
  return out;
}

}  // namespace vir::check
