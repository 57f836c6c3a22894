#include "anchor_places.h"

#include <algorithm>
#include <cstdio>
#include <string>

namespace vir {
namespace {

constexpr double kUnknown = 99999;   // m; a place farther off is none
constexpr double kSame = 1e-3;       // m; numbers are written with three decimals
constexpr std::size_t kMost = 4096;  // ids that are noise must not grow the memory
constexpr std::size_t kNamed = 10;   // in a message

}  // namespace

void AnchorPlaces::add(std::uint64_t anchor, const Vec3& p_S) {
  if (!p_S.allFinite() || p_S.cwiseAbs().maxCoeff() >= kUnknown) return;
  const auto known = places_.find(anchor);
  if (known != places_.end()) {
    const double off = (p_S - known->second.first).norm();
    known->second.farthest = std::max(known->second.farthest, off);
  } else if (places_.size() < kMost) {
    places_[anchor].first = p_S;
  }
}

bool AnchorPlaces::anyFilledIn() const {
  return std::any_of(places_.begin(), places_.end(), [](const auto& p) {
    return p.second.farthest > kSame || !p.second.first.isZero(0);
  });
}

std::vector<SurveyedAnchor> AnchorPlaces::standing() const {
  std::vector<SurveyedAnchor> out;
  if (!anyFilledIn()) return out;
  for (const auto& [id, place] : places_) {
    if (place.farthest > kSame) continue;
    SurveyedAnchor anchor;
    anchor.id = id;
    anchor.p_S = place.first;
    out.push_back(anchor);
  }
  return out;
}

void AnchorPlaces::say(ProblemLog* log) const {
  if (places_.empty()) return;
  if (!anyFilledIn()) {
    log->note("the ranges say of every anchor that it is at 0 0 0: not used");
    return;
  }
  std::string ids;
  std::size_t moving = 0;
  double farthest = 0;
  for (const auto& [id, place] : places_) {
    if (place.farthest <= kSame) continue;
    farthest = std::max(farthest, place.farthest);
    if (++moving <= kNamed) ids += (ids.empty() ? "" : ", ") + std::to_string(id);
  }
  if (moving == 0) return;
  char apart[32];
  std::snprintf(apart, sizeof apart, "%.3g", farthest);
  log->note((moving == 1 ? "anchor " : "anchors ") + ids + (moving > kNamed ? ", ..." : "") +
            ": the ranges say places up to " + apart + " m apart, so " +
            (moving == 1 ? "it moves and is" : "they move and are") +
            " left out of the surveyed anchors");
}

}  // namespace vir
