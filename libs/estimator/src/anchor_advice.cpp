/// What somebody who moves the robot can do for an anchor.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "range_layer_impl.h"

namespace vir::estimator {
namespace {

/// A step is long enough when what it tells is so many standard deviations of a range.
constexpr double kTellingSigmas = 3;

std::string lengthOfWeakest(const Anchor& a, double enough_m) {
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(a.covariance);
  const double largest = std::sqrt(std::max(0.0, eigen.eigenvalues()[2]));
  if (!(largest > enough_m)) return {};
  char text[120];
  std::snprintf(text, sizeof text, "%s: one direction is known to %.1f m only",
                std::abs(eigen.eigenvectors()(2, 2)) > 0.7 ? "change height" : "move sideways",
                largest);
  return text;
}

std::string inWords(const Vec3& step_W, const Vec3& to_W) {
  char text[120];
  if (step_W.head<2>().isZero()) {
    std::snprintf(text, sizeof text, "; %.1f m %s would tell most", std::abs(step_W.z()),
                  step_W.z() > 0 ? "up" : "down");
  } else {
    std::snprintf(text, sizeof text, "; %.1f m to (%.1f, %.1f, %.1f) would tell most",
                  step_W.norm(), to_W.x(), to_W.y(), to_W.z());
  }
  return text;
}

}  // namespace

void RangeLayer::Impl::advise(const AnchorTrack& track, Anchor* anchor) const {
  if (anchor->has_position && anchor->advice.empty()) {
    anchor->advice = lengthOfWeakest(*anchor, options.max_anchor_sigma_m);
  }
  if (anchor->advice.empty() || !any_antenna) return;
  std::vector<ranging::AnchorHypothesis> in_question;
  if (const Collecting* collecting = track.collecting()) {
    in_question = collecting->candidates;
  } else if (anchor->state == AnchorState::mirror_open) {
    // Its covariance spans both positions: what is left of it is that of either.
    const Vec3 half = 0.5 * (anchor->mirror_p_W - anchor->p_W);
    const Mat3 own = anchor->covariance - half * half.transpose();
    in_question = {{anchor->p_W, own}, {anchor->mirror_p_W, own}};
  } else if (anchor->has_position) {
    in_question = {{anchor->p_W, anchor->covariance}};
  }
  const auto way = ranging::nextWaypoint(last_antenna, in_question,
                                         kTellingSigmas * options.sigma_m, lowest_antenna_m);
  if (!way) return;
  anchor->waypoint_W = last_antenna + way->step_W;
  anchor->advice += inWords(way->step_W, *anchor->waypoint_W);
}

}  // namespace vir::estimator
