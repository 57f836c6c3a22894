#include "place_graph.h"

namespace vir::mission {
namespace {

/// The places' check against the path is a first one, of a path that may be worse than it says; the
/// graph has the last word. Times the variance.
constexpr double kPriorDoubt = 4;
/// Roll and pitch of two keyframes against each other [rad].
constexpr double kTiltSigma = 0.01;

std::optional<places::RelativePrior> priorOf(const MissionGraph& graph, const PlaceKeyframe& older,
                                             const PlaceKeyframe& newer) {
  const auto known = graph.relative(older.id, newer.id);
  if (!known) return std::nullopt;
  const Quat q_older = older.T_W_B.q, q_newer = newer.T_W_B.q;
  places::RelativePrior out;
  out.T_older_newer =
      Pose((q_older.conjugate() * Quat(rotZ(known->turn_rad)) * q_newer).normalized(),
           q_older.conjugate() * known->motion_W);
  Eigen::Matrix<double, 6, 4> J = Eigen::Matrix<double, 6, 4>::Zero();
  J.topLeftCorner<3, 3>() = q_older.conjugate().toRotationMatrix();
  J.bottomRightCorner<3, 1>() = q_newer.conjugate() * Vec3::UnitZ();
  out.covariance = kPriorDoubt * J * known->covariance * J.transpose();
  out.covariance.diagonal().head<3>().array() += 1e-6;
  out.covariance.diagonal().tail<3>().array() += kTiltSigma * kTiltSigma;
  return out;
}

}  // namespace

void PlaceGraph::remember(const PlaceKeyframe& keyframe) {
  // Stamps of another run may be those of this one: they tell nothing of the two.
  auto copy = std::make_shared<PlaceKeyframe>(keyframe);
  copy->segment = -1 - keyframe.segment;
  graph_.addFixed(keyframe.id, keyframe.t, keyframe.T_W_B);
  finder_.remember(std::move(copy));
}

long PlaceGraph::add(std::shared_ptr<const PlaceKeyframe> k, const PathNode& node, bool look) {
  graph_.add(node);
  looked_ = look;
  if (!look) {
    finder_.remember(std::move(k));
    return 0;
  }
  const auto prior = [this](const PlaceKeyframe& older, const PlaceKeyframe& newer) {
    return priorOf(graph_, older, newer);
  };
  long accepted = 0;
  for (const Loop& loop : finder_.add(std::move(k), prior)) {
    if (graph_.offer(loop) == LoopState::accepted) ++accepted;
  }
  return accepted;
}

std::vector<places::LoopAttempt> PlaceGraph::attempts() const {
  return looked_ ? finder_.attempts() : std::vector<places::LoopAttempt>();
}

}  // namespace vir::mission
