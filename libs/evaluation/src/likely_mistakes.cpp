#include "vir/evaluation/likely_mistakes.h"

#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>

namespace vir::evaluation {
namespace {

/// Smaller errors are nobody's mistake.
constexpr double kBadDeg = 15, kBadM = 0.02;
constexpr double kBetter = 1.0 / 3;  // of the errors, at most
constexpr double kReachS = 0.3, kStepS = 0.01;

using Change = std::function<Pose(const Pose&)>;

Trajectory changed(const Trajectory& all, const Change& change) {
  Trajectory out = all;
  for (StampedPose& p : out) p.T_W_B = change(p.T_W_B);
  return out;
}

Trajectory later(const Trajectory& all, double by_s) {
  Trajectory out = all;
  for (StampedPose& p : out) p.t += fromSeconds(by_s);
  return out;
}

std::optional<EvaluationResult> again(const Trajectory& reference, const Trajectory& estimate,
                                      const EvaluationOptions& options) {
  try {
    return evaluate(reference, estimate, options);
  } catch (const EvaluationError&) {
    return std::nullopt;
  }
}

template <typename... Args>
std::string printed(const char* format, Args... args) {
  char text[400];
  std::snprintf(text, sizeof text, format, args...);
  return text;
}

Pose wFirst(const Pose& T) {  // x y z w was read where w x y z was written
  return Pose(Quat(T.q.x(), T.q.y(), T.q.z(), T.q.w()), T.p);
}
Pose wLast(const Pose& T) {
  Quat q;
  q.coeffs() << T.q.w(), T.q.x(), T.q.y(), T.q.z();
  return Pose(q, T.p);
}
Pose turnedBack(const Pose& T) { return Pose(T.q.conjugate(), T.p); }

struct AttitudeMistake {
  Change change;
  const char* text;
};

std::vector<std::string> ofAttitudes(const Trajectory& reference, const Trajectory& estimate,
                                     const EvaluationOptions& options,
                                     const EvaluationResult& result) {
  const double bad = result.ate_orientation_deg.rmse;
  if (!result.attitudes || bad < kBadDeg) return {};
  const AttitudeMistake mistakes[] = {
      {wFirst, "as w x y z (it was read as x y z w)"},
      {wLast, "as x y z w (it was read as w x y z)"},
      {turnedBack, "the other way round (world in body)"},
  };
  for (const AttitudeMistake& mistake : mistakes) {
    for (const bool of_reference : {true, false}) {
      const auto r = of_reference ? again(changed(reference, mistake.change), estimate, options)
                                  : again(reference, changed(estimate, mistake.change), options);
      if (!r || r->ate_orientation_deg.rmse > kBetter * bad) continue;
      return {printed(
          "the attitudes of the %s agree to %.2f instead of %.1f deg if they are taken %s",
          of_reference ? "reference" : "estimate", r->ate_orientation_deg.rmse, bad, mistake.text)};
    }
  }
  return {};
}

std::vector<std::string> ofUnits(const Trajectory& reference, const Trajectory& estimate,
                                 const EvaluationOptions& options, const EvaluationResult& result) {
  struct Unit {
    double per_metre;
    const char* text;
  };
  for (const Unit& unit : {Unit{1000, "mm"}, Unit{100, "cm"}, Unit{1 / 0.3048, "feet"}}) {
    for (const bool of_reference : {true, false}) {
      const double scale = of_reference ? unit.per_metre : 1 / unit.per_metre;
      if (std::abs(result.best_scale / scale - 1) > 0.03) continue;
      const auto shrink = [&](const Pose& T) { return Pose(T.q, T.p / unit.per_metre); };
      const auto r = of_reference ? again(changed(reference, shrink), estimate, options)
                                  : again(reference, changed(estimate, shrink), options);
      if (!r || r->ate_position_m.rmse > kBetter * result.ate_position_m.rmse) continue;
      return {printed("the positions of the %s seem to be in %s: the error is %.4f m then",
                      of_reference ? "reference" : "estimate", unit.text, r->ate_position_m.rmse)};
    }
  }
  return {};
}

std::vector<std::string> ofInverse(const Trajectory& reference, const Trajectory& estimate,
                                   const EvaluationOptions& options,
                                   const EvaluationResult& result) {
  if (!result.attitudes) return {};
  const auto inverse = [](const Pose& T) { return T.inverse(); };
  for (const bool of_reference : {true, false}) {
    const auto r = of_reference ? again(changed(reference, inverse), estimate, options)
                                : again(reference, changed(estimate, inverse), options);
    if (!r || r->ate_position_m.rmse > kBetter * result.ate_position_m.rmse) continue;
    return {
        printed("the poses of the %s seem to be the inverse (the world in the body): with them "
                "turned round the error is %.4f m",
                of_reference ? "reference" : "estimate", r->ate_position_m.rmse)};
  }
  return {};
}

std::vector<std::string> ofClock(const Trajectory& reference, const Trajectory& estimate,
                                 const EvaluationOptions& options, const EvaluationResult& result) {
  double best_s = 0, best_m = result.ate_position_m.rmse;
  for (double by_s = -kReachS; by_s <= kReachS + 1e-9; by_s += kStepS) {
    const auto r = again(later(reference, by_s), estimate, options);
    if (!r || r->ate_position_m.rmse >= best_m) continue;
    best_m = r->ate_position_m.rmse;
    best_s = by_s;
  }
  if (best_m > kBetter * result.ate_position_m.rmse) return {};
  return {
      printed("the clocks seem to be off: with the reference stamped %.0f ms %s the error is "
              "%.4f m",
              1e3 * std::abs(best_s), best_s > 0 ? "later" : "earlier", best_m)};
}

}  // namespace

std::vector<std::string> likelyMistakes(const Trajectory& reference, const Trajectory& estimate,
                                        const EvaluationOptions& options,
                                        const EvaluationResult& result) {
  EvaluationOptions quick = options;
  quick.distances_m.clear();
  std::vector<std::string> out = ofAttitudes(reference, estimate, quick, result);
  if (result.ate_position_m.rmse < kBadM) return out;
  for (auto* mistake : {ofUnits, ofInverse, ofClock}) {
    const std::vector<std::string> found = mistake(reference, estimate, quick, result);
    out.insert(out.end(), found.begin(), found.end());
    if (!found.empty()) break;  // the others would be a consequence
  }
  return out;
}

}  // namespace vir::evaluation
