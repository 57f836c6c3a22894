#include "vir/places/loop_finder.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "likeness.h"

namespace vir::places {
namespace {

using Mat6 = Eigen::Matrix<double, 6, 6>;

/// Of a path over a few seconds, beside its share of the way. [m, rad]
constexpr double kPath_m = 0.02, kPath_rad = 0.01;
/// Where several places look the same, odometry and ranges must be at ease with the one that is
/// chosen (95 % of six degrees of freedom), and prefer it to any other by so much.
constexpr double kAtEase = 12.6, kPreferred = 20;
/// Keyframes so far apart may see the same corners.
constexpr double kNear_m = 3;
/// Images that show fewer corners than this, all together, tell of no place.
constexpr int kViewed = 30;
/// An image that shows less than this of what must be in view has no voice: its pose is off, if it
/// is the place at all.
constexpr double kLeastAlike = 0.5;

/// Where the covariance of a chain of poses goes: T = A B, each of (position in the frame on the
/// left, rotation on the right).
RelativePrior chained(const RelativePrior& a, const RelativePrior& b) {
  RelativePrior out;
  out.T_older_newer = a.T_older_newer * b.T_older_newer;
  const Mat3 R_a = a.T_older_newer.R(), R_b = b.T_older_newer.R();
  Mat6 of_a = Mat6::Identity(), of_b = Mat6::Identity();
  of_a.topRightCorner<3, 3>() = -R_a * hat(b.T_older_newer.p);
  of_a.bottomRightCorner<3, 3>() = R_b.transpose();
  of_b.topLeftCorner<3, 3>() = R_a;
  out.covariance = of_a * a.covariance * of_a.transpose() + of_b * b.covariance * of_b.transpose();
  return out;
}

RelativePrior inverse(const RelativePrior& a) {
  RelativePrior out;
  out.T_older_newer = a.T_older_newer.inverse();
  const Mat3 R = a.T_older_newer.R();
  Mat6 J = Mat6::Zero();
  J.topLeftCorner<3, 3>() = -R.transpose();
  J.topRightCorner<3, 3>() = -hat(R.transpose() * a.T_older_newer.p);
  J.bottomRightCorner<3, 3>() = -R;
  out.covariance = J * a.covariance * J.transpose();
  return out;
}

RelativePrior relation(const Loop& loop) { return {loop.T_older_newer, loop.covariance}; }

}  // namespace

LoopFinder::LoopFinder(const LoopFinderOptions& options, const PlaceIndexOptions& index,
                       const VerifyOptions& verify)
    : options_(options), verify_(verify), index_(index) {
  options.validate();
  verify.validate();
}

void LoopFinder::remember(std::shared_ptr<const PlaceKeyframe> keyframe) {
  index_.add(std::move(keyframe));
}

std::vector<Loop> LoopFinder::add(std::shared_ptr<const PlaceKeyframe> keyframe, const Prior& prior,
                                  const PlaceIndex::Allowed& allowed, const Compare& compare) {
  attempts_.clear();
  std::vector<Loop> out;
  if (keyframe) {
    for (Opinion& o : look(keyframe, prior, allowed, compare != nullptr)) {
      if (!o.known && compare) {
        const Likeness l = likeness(o.loop, *o.older, *o.newer, compare);
        o.compared = true;
        o.in_view = l.in_view;
        o.alike = l.alike;
      }
      const std::vector<Loop> believed = confirm(std::move(o), prior);
      out.insert(out.end(), believed.begin(), believed.end());
    }
    recent_.emplace_back(keyframe->id, keyframe->t);
  }
  index_.add(std::move(keyframe));
  return out;
}

/// Verifies the candidates; the best of them, unless another place is nearly as good.
std::vector<LoopFinder::Opinion> LoopFinder::look(
    const std::shared_ptr<const PlaceKeyframe>& keyframe, const Prior& prior,
    const PlaceIndex::Allowed& allowed, bool compares) {
  while (!recent_.empty() && toSeconds(keyframe->t - recent_.front().second) > options_.recent_s) {
    recent_.pop_front();
  }
  const std::uint64_t before = recent_.empty() ? keyframe->id : recent_.front().first;
  std::vector<Opinion> found;
  std::vector<std::size_t> attempt_of;
  for (const PlaceCandidate& c : index_.query(*keyframe, before, allowed)) {
    const auto candidate = index_.find(c.id);
    const std::optional<RelativePrior> known = prior ? prior(*candidate, *keyframe) : std::nullopt;
    const bool sure = saysWhere(known ? &*known : nullptr, verify_);
    const auto older =
        index_.around(c.id, sure ? options_.neighbours : options_.neighbours_unknown);
    LoopAttempt attempt;
    attempt.older = c.id;
    attempt.newer = keyframe->id;
    attempt.score = c.score;
    attempt.verdict = verifyLoop(*keyframe, older, verify_, known ? &*known : nullptr);
    if (attempt.verdict.found && !hasCorners(attempt.verdict, compares)) {
      attempt.verdict.found.reset();
      attempt.verdict.refusal = LoopRefusal::few_inliers;
    }
    attempt.decision = name(attempt.verdict.refusal);
    if (attempt.verdict.found) {
      const bool weak = attempt.verdict.refusal == LoopRefusal::few_inliers;
      found.push_back({*attempt.verdict.found, attempt.verdict.chi2, attempt.verdict.known,
                       attempt.verdict.loop.has_value(), weak, older.front(), keyframe});
      attempt_of.push_back(attempts_.size());
      if (attempt.verdict.loop) attempt.decision = "second to another";
    }
    attempts_.push_back(std::move(attempt));
  }
  const std::optional<std::size_t> best = choose(found);
  if (!best) return {};
  LoopAttempt& attempt = attempts_[attempt_of[*best]];
  const bool sure =
      unique(found, *best, prior) && (found[*best].allowed || outstanding(attempt, prior));
  attempt.decision = sure ? "waits for another" : "ambiguous";
  if (!sure) return {};
  return {found[*best]};
}

/// Is it a place that it could be? Where the image will be compared fewer corners are enough.
bool LoopFinder::hasCorners(const LoopVerdict& v, bool compares) const {
  if (compares && !v.known) return true;
  return v.inliers >= std::min(verify_.min_inliers_alone, verify_.min_inliers_known) &&
         v.share >= std::min(verify_.min_share_alone, verify_.min_share_known);
}

/// Of those with nearly the most corners, the one that odometry and ranges like best. Where none
/// has enough of them, those that have too few.
std::optional<std::size_t> LoopFinder::choose(const std::vector<Opinion>& found) const {
  const bool any =
      std::any_of(found.begin(), found.end(), [](const Opinion& o) { return o.allowed; });
  const auto may = [any](const Opinion& o) { return any ? o.allowed : o.weak; };
  int most = 0;
  for (const Opinion& o : found) {
    if (may(o)) most = std::max(most, o.loop.inliers);
  }
  std::optional<std::size_t> best;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Opinion& o = found[k];
    if (!may(o) || o.loop.inliers < options_.ambiguous * most) continue;
    const auto better = [](const Opinion& a, const Opinion& b) {
      return a.chi2 != b.chi2 ? a.chi2 < b.chi2 : a.loop.inliers > b.loop.inliers;
    };
    if (!best || better(o, found[*best])) best = k;
  }
  return best;
}

/// Is no other place nearly as good, or clearly refused by odometry and ranges?
bool LoopFinder::unique(const std::vector<Opinion>& found, std::size_t chosen,
                        const Prior& prior) const {
  const Opinion& best = found[chosen];
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Opinion& other = found[k];
    if (k == chosen || other.loop.inliers < options_.ambiguous * best.loop.inliers) continue;
    if (samePlace(best, other, prior)) continue;
    if (best.chi2 > kAtEase || other.chi2 < best.chi2 + kPreferred) return false;
  }
  return true;
}

/// Has no place elsewhere even a few corners? Where things look alike some have.
bool LoopFinder::outstanding(const LoopAttempt& best, const Prior& prior) const {
  return std::none_of(attempts_.begin(), attempts_.end(), [&](const LoopAttempt& other) {
    if (other.older == best.older) return false;
    if (other.verdict.inliers < options_.outstanding * best.verdict.inliers) return false;
    const auto a = index_.find(best.older), b = index_.find(other.older);
    const auto apart = between(*a, *b, prior);
    return !apart || apart->T_older_newer.p.norm() > kNear_m;
  });
}

/// What is known of `b` as seen from `a`: by the caller, or by the path where it is short.
std::optional<RelativePrior> LoopFinder::between(const PlaceKeyframe& a, const PlaceKeyframe& b,
                                                 const Prior& prior) const {
  const bool near =
      a.segment == b.segment && std::abs(toSeconds(a.t - b.t)) <= 2 * options_.agree_s;
  if (near) {
    RelativePrior out;
    out.T_older_newer = a.T_W_B.inverse() * b.T_W_B;
    const double way = options_.path_share * out.T_older_newer.p.norm();
    out.covariance.setZero();
    out.covariance.diagonal().head<3>().setConstant(kPath_m * kPath_m + way * way);
    out.covariance.diagonal().tail<3>().setConstant(kPath_rad * kPath_rad);
    return out;
  }
  if (!prior) return std::nullopt;
  if (a.id <= b.id) return prior(a, b);
  const std::optional<RelativePrior> turned = prior(b, a);
  return turned ? std::optional<RelativePrior>(inverse(*turned)) : std::nullopt;
}

/// Do both put the newer keyframe at the same place?
bool LoopFinder::samePlace(const Opinion& a, const Opinion& b, const Prior& prior) const {
  const std::optional<RelativePrior> apart = between(*a.older, *b.older, prior);
  if (apart) {
    const RelativePrior by_b = chained(*apart, relation(b.loop));
    return loopChi2(a.loop, by_b) <= options_.agree_chi2;
  }
  if (a.older->segment != b.older->segment) return false;
  const Pose at_a = a.older->T_W_B * a.loop.T_older_newer;
  const Pose at_b = b.older->T_W_B * b.loop.T_older_newer;
  return (at_a.p - at_b.p).norm() <= options_.apart_m &&
         at_a.q.angularDistance(at_b.q) <= options_.apart_rad;
}

/// Does an opinion of a keyframe shortly before say the same?
bool LoopFinder::agree(const Opinion& now, const Opinion& before, const Prior& prior) const {
  const std::optional<RelativePrior> older = between(*now.older, *before.older, prior);
  const std::optional<RelativePrior> newer = between(*before.newer, *now.newer, {});
  if (!older || !newer) return false;
  if (newer->T_older_newer.p.norm() < options_.agree_move_m) return false;
  const RelativePrior by_before = chained(chained(*older, relation(before.loop)), *newer);
  return loopChi2(now.loop, by_before) <= options_.agree_chi2;
}

/// Do so many agree? Where each has few corners, one more must, and all together must have as many
/// as those of whom fewer are enough.
bool LoopFinder::enough(const Opinion& now, const std::vector<Opinion*>& agreeing) const {
  const int needed = now.known ? options_.agreeing : options_.agreeing_unknown;
  int strong = now.allowed ? 1 : 0, all = 1, corners = now.loop.inliers;
  for (const Opinion* o : agreeing) {
    strong += o->allowed ? 1 : 0;
    ++all;
    corners += o->loop.inliers;
  }
  return strong >= needed || (all > needed && corners >= needed * verify_.min_inliers);
}

/// Do the images show together what must be in view? Where it is known where the place is, and
/// where there was no image, nobody asks.
bool LoopFinder::alike(const Opinion& now, const std::vector<Opinion*>& agreeing) const {
  if (now.known || !now.compared) return true;
  int in_view = now.in_view, alike = now.alike;
  for (const Opinion* o : agreeing) {
    in_view += o->in_view;
    alike += o->alike;
  }
  return in_view >= kViewed && alike >= options_.min_alike * in_view;
}

void LoopFinder::decide(const Opinion& opinion, const char* decision) {
  for (LoopAttempt& a : attempts_) {
    if (a.older == opinion.loop.older) a.decision = decision;
  }
}

std::vector<Loop> LoopFinder::confirm(Opinion opinion, const Prior& prior) {
  const TimeNs now = opinion.newer->t;
  waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(),
                                [&](const Opinion& o) {
                                  return toSeconds(now - o.newer->t) > options_.agree_s;
                                }),
                 waiting_.end());
  if (opinion.compared && opinion.alike < kLeastAlike * opinion.in_view) {
    decide(opinion, "unlike");
    return {};
  }
  std::vector<Opinion*> agreeing;
  for (Opinion& o : waiting_) {
    if (agree(opinion, o, prior)) agreeing.push_back(&o);
  }
  std::vector<Loop> out;
  if (enough(opinion, agreeing) && !alike(opinion, agreeing)) {
    decide(opinion, "unlike");
  } else if (enough(opinion, agreeing)) {
    for (Opinion* o : agreeing) {
      if (!o->told) out.push_back(o->loop);
      o->told = true;
    }
    out.push_back(opinion.loop);
    opinion.told = true;
    decide(opinion, "accepted");
  }
  waiting_.push_back(std::move(opinion));
  return out;
}

}  // namespace vir::places
