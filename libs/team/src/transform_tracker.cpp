#include "vir/team/transform_tracker.h"

#include <algorithm>
#include <cmath>

#include "evidence_cost.h"
#include "moved_frame.h"
#include "thin_out.h"
#include "vir/core/option_check.h"
#include "vir/core/options.h"

namespace vir::team {
namespace {

constexpr double kSameSigmas = 2;  // farther off, the best solution is another one

}  // namespace

void TransformTrackerOptions::validate() const { checkBounds(*this); }

void describe(OptionVisitor& v, TransformTrackerOptions& o) {
  describe(v, o.transform);
  v.value("max_ranges", o.max_ranges, {20, 1000000},
          "ranges kept per pair; beyond, every second of the older half is dropped");
}

TransformTracker::TransformTracker(const TransformTrackerOptions& options) : options_(options) {
  options_.validate();
}

void TransformTracker::add(const MutualRange& range, int segment_A, int segment_B) {
  if (seen_ == 0) {
    segment_A_ = segment_A;
    segment_B_ = segment_B;
  }
  if (segment_A < segment_A_ || segment_B < segment_B_) return;
  if (segment_A > segment_A_ || segment_B > segment_B_) {
    ranges_.clear();
    hints_.clear();
    anchors_.clear();
    decided_.reset();
    segment_A_ = segment_A;
    segment_B_ = segment_B;
    seen_ = 0;
    ++restarts_;
  }
  ++seen_;
  // Those that the other robot has measured can come after younger ones.
  const auto behind = std::upper_bound(ranges_.begin(), ranges_.end(), range.t,
                                       [](TimeNs t, const MutualRange& r) { return t < r.t; });
  ranges_.insert(behind, range);
  thinOut(static_cast<std::size_t>(options_.max_ranges), &ranges_);
}

void TransformTracker::moveA(const WorldTransform& T_new_A) {
  for (MutualRange& range : ranges_) team::moveA(T_new_A, &range);
  for (SharedAnchor& anchor : anchors_) team::moveA(T_new_A, &anchor);
  if (places_) team::moveA(T_new_A, &*places_);
  for (WorldTransform& hint : hints_) hint = T_new_A * hint;
  if (!decided_) return;
  decided_->T = T_new_A * decided_->T;
  decided_->covariance = movedCovariance(T_new_A, decided_->covariance);
}

bool TransformTracker::stillDecided(const TransformAnswer& answer) const {
  const bool open =
      answer.status == TransformStatus::ambiguous || answer.status == TransformStatus::degenerate;
  if (!decided_ || !open || answer.solutions.empty()) return false;
  // Still what it was, as far as that was known.
  const WorldTransform& best = answer.solutions[0].T_A_B;
  const Vec3& p_B = ranges_.empty() ? places_->centre_B : ranges_.back().p_B;
  const Mat3x4 J = pointJacobian(rotZ(decided_->T.yaw_rad) * p_B);
  const Mat3 C = J * decided_->covariance * J.transpose();
  const double yaw_sigma = std::sqrt(std::max(0.0, decided_->covariance(0, 0)));
  const double turned = std::abs(wrapAngle(best.yaw_rad - decided_->T.yaw_rad));
  Vec3 apart = best * p_B - decided_->T * p_B;
  if (decided_->height_open || answer.height_open) apart.z() = 0;
  const double known_m = kSameSigmas * std::sqrt(std::max(0.0, C(0, 0) + C(1, 1)));
  return turned < std::max(options_.transform.max_yaw_sigma_rad, kSameSigmas * yaw_sigma) &&
         apart.norm() < std::max(options_.transform.same_solution_m, known_m);
}

std::optional<SharedPlaces> TransformTracker::placesNow() const {
  if (!places_ || seen_ == 0) return places_;
  const bool now = places_->segment_A == segment_A_ && places_->segment_B == segment_B_;
  return now ? places_ : std::nullopt;
}

TransformAnswer TransformTracker::answer() {
  TransformAnswer answer =
      findTransform(ranges_, anchors_, options_.transform, hints_, placesNow());
  if (stillDecided(answer)) {
    answer.status = TransformStatus::unique;
    answer.reason.clear();
    answer.solutions.resize(1);
  }
  decided_.reset();
  if (answer.status == TransformStatus::unique) {
    const TransformSolution& best = answer.solutions[0];
    decided_ = Decided{best.T_A_B, best.covariance, answer.height_open};
  }
  hints_.clear();
  for (const TransformSolution& s : answer.solutions) hints_.push_back(s.T_A_B);
  return answer;
}

}  // namespace vir::team
