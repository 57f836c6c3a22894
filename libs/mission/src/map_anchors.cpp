#include "map_anchors.h"

#include <Eigen/LU>
#include <cstdint>
#include <cstdio>
#include <map>

#include "anchor_fix.h"

namespace vir::mission {
namespace {

/// Steps of the weight between the two that are tried: the minimum is flat.
constexpr int kWeights = 20;

/// Covariance intersection: a weighted sum of what both know, never surer than the two allow if
/// their errors are the same ones. Weights 0 and 1 are the anchors themselves.
Anchor fused(const Anchor& before, const Anchor& now) {
  const bool better = now.covariance.trace() < before.covariance.trace();
  Anchor out = better ? now : before;
  const Mat3 of_before = before.covariance.inverse(), of_now = now.covariance.inverse();
  if (!of_before.allFinite() || !of_now.allFinite()) return out;  // one is given, not found
  const Anchor best = out;
  for (int i = 1; i < kWeights; ++i) {
    const double w = static_cast<double>(i) / kWeights;
    const Mat3 P = (w * of_before + (1 - w) * of_now).inverse();
    if (!(P.trace() < out.covariance.trace())) continue;
    out.covariance = 0.5 * (P + P.transpose());
    out.p_W = P * (w * (of_before * before.p_W) + (1 - w) * (of_now * now.p_W));
  }
  return out.p_W.allFinite() ? out : best;
}

void warn(const Anchor& before, const Anchor& now, const LogSink& sink) {
  char text[240];
  std::snprintf(text, sizeof text,
                "anchor %llu is %.2f m from where the map has it: the map keeps its own; if the "
                "anchor was moved, make a new map, or give it another id",
                static_cast<unsigned long long>(now.id), (now.p_W - before.p_W).norm());
  log(sink, LogLevel::warning, text);
}

}  // namespace

std::vector<Anchor> joinAnchors(const std::vector<Anchor>& before, const std::vector<Anchor>& now,
                                const LogSink& sink) {
  std::map<std::uint64_t, Anchor> known;
  for (const Anchor& a : before) known[a.id] = a;
  for (const Anchor& a : now) {
    if (!a.has_position) continue;
    const auto [at, fresh] = known.try_emplace(a.id, a);
    if (fresh) continue;
    if (!isKnown(at->second)) {
      at->second = a;
    } else if (isKnown(a)) {
      if (fits(at->second, a)) {
        at->second = fused(at->second, a);
      } else {
        warn(at->second, a, sink);
      }
    }
  }
  std::vector<Anchor> out;
  for (const auto& [id, a] : known) out.push_back(a);
  return out;
}

}  // namespace vir::mission
