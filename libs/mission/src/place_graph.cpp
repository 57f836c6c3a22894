#include "place_graph.h"

#include <cmath>

#include "anchor_fix.h"
#include "graph_edges.h"

namespace vir::mission {
namespace {

/// The places' check against the path is a first one, of a path that may be worse than it says; the
/// graph has the last word. Times the variance.
constexpr double kPriorDoubt = 4;
/// Roll and pitch of two keyframes against each other [rad].
constexpr double kTiltSigma = 0.01;

/// No place is found again from farther off [m].
constexpr double kReach = 15;
/// Anchors contradict a loop above this chi-square, of three degrees of freedom (0.1 %), and so
/// much more per further anchor.
constexpr double kAnchorGate = 16.3, kPerAnchor = 6;
/// Times the variance of loops that a run is found in a map by: their keyframes are of its first
/// seconds, whose roll, pitch and scale are young. Those that follow say where it is.
constexpr double kFirstDoubt = 9;

places::RelativePrior asPrior(const MissionGraph::Relative& known, const PlaceKeyframe& older,
                              const PlaceKeyframe& newer) {
  const Quat q_older = older.T_W_B.q, q_newer = newer.T_W_B.q;
  places::RelativePrior out;
  out.T_older_newer =
      Pose((q_older.conjugate() * Quat(rotZ(known.turn_rad)) * q_newer).normalized(),
           q_older.conjugate() * known.motion_W);
  Eigen::Matrix<double, 6, 4> J = Eigen::Matrix<double, 6, 4>::Zero();
  J.topLeftCorner<3, 3>() = q_older.conjugate().toRotationMatrix();
  J.bottomRightCorner<3, 1>() = q_newer.conjugate() * Vec3::UnitZ();
  out.covariance = kPriorDoubt * J * known.covariance * J.transpose();
  out.covariance.diagonal().head<3>().array() += 1e-6;
  out.covariance.diagonal().tail<3>().array() += kTiltSigma * kTiltSigma;
  return out;
}

}  // namespace

void PlaceGraph::setAnchors(const std::vector<Anchor>& in_M, const std::vector<Anchor>& in_W) {
  anchors_M_ = in_M;
  anchors_W_ = in_W;
  T_M_W_ = fixByAnchors(in_M, in_W);
}

std::optional<places::RelativePrior> PlaceGraph::priorOf(const PlaceKeyframe& older,
                                                         const PlaceKeyframe& newer) const {
  if (const auto known = graph_.relative(older.id, newer.id)) return asPrior(*known, older, newer);
  if (!T_M_W_ || older.segment >= 0) return std::nullopt;
  // A map's keyframe, as the anchors have it: a coarse place is enough to know where to look.
  const LevelGuess newer_M = *T_M_W_ * LevelGuess{{0, newer.T_W_B.p}, Eigen::Matrix4d::Zero()};
  return asPrior({newer_M.T.t_m - older.T_W_B.p, newer_M.T.yaw_rad, newer_M.P}, older, newer);
}

bool PlaceGraph::inReach(const PlaceKeyframe& older, const PlaceKeyframe& newer) const {
  if (older.segment >= 0) return true;
  const LevelGuess newer_M = *T_M_W_ * LevelGuess{{0, newer.T_W_B.p}, Eigen::Matrix4d::Zero()};
  const double sigma = std::sqrt(newer_M.P.topLeftCorner<3, 3>().trace());
  return (newer_M.T.t_m - older.T_W_B.p).norm() <= kReach + 3 * sigma;
}

bool PlaceGraph::anchorsAllow(const Loop& loop, const PlaceKeyframe& newer) const {
  const auto older = finder_.index().find(loop.older);
  if (anchors_W_.empty() || !older || older->segment >= 0) return true;
  const LevelLoop l = levelLoop(loop, older->T_W_B, newer.T_W_B, {});
  const LevelGuess newer_M{{l.turn_rad, older->T_W_B.p + l.motion_W}, l.covariance};
  const LevelGuess at{{0, newer.T_W_B.p}, Eigen::Matrix4d::Zero()};
  const AnchorFit fit = anchorFit(newer_M * inverse(at), anchors_M_, anchors_W_);
  return fit.dof == 0 || fit.chi2 <= kAnchorGate + kPerAnchor * (fit.dof / 3 - 1);
}

void PlaceGraph::remember(const PlaceKeyframe& keyframe) {
  // Stamps of another run may be those of this one: they tell nothing of the two.
  auto copy = std::make_shared<PlaceKeyframe>(keyframe);
  copy->segment = -1 - keyframe.segment;
  graph_.addFixed(keyframe.id, keyframe.t, keyframe.T_W_B);
  finder_.remember(std::move(copy));
}

long PlaceGraph::add(std::shared_ptr<const PlaceKeyframe> k, const PathNode& node, bool look,
                     const places::LoopFinder::Compare& compare) {
  graph_.add(node);
  looked_ = look;
  against_anchors_.clear();
  if (!look) {
    finder_.remember(std::move(k));
    return 0;
  }
  const auto prior = [this](const PlaceKeyframe& older, const PlaceKeyframe& newer) {
    return priorOf(older, newer);
  };
  places::PlaceIndex::Allowed allowed;
  if (T_M_W_) {
    allowed = [this, k](const PlaceKeyframe& older) { return inReach(older, *k); };
  } else if (map_only_) {
    allowed = [](const PlaceKeyframe& older) { return older.segment < 0; };
  }
  long accepted = 0;
  const bool arrives = !graph_.joined();
  for (Loop loop : finder_.add(k, prior, allowed, compare)) {
    const auto newer = finder_.index().find(loop.newer);
    if (newer && !anchorsAllow(loop, *newer)) {
      against_anchors_.push_back(loop);
      continue;
    }
    const auto older = finder_.index().find(loop.older);
    if (arrives && older && older->segment < 0) loop.covariance *= kFirstDoubt;
    if (graph_.offer(loop) == LoopState::accepted) ++accepted;
  }
  return accepted;
}

std::vector<places::LoopAttempt> PlaceGraph::attempts() const {
  return looked_ ? finder_.attempts() : std::vector<places::LoopAttempt>();
}

}  // namespace vir::mission
