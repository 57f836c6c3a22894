#include "vir/mission/mission_graph.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "graph_state.h"
#include "vir/core/option_check.h"
#include "vir/geometry/finite_pose.h"

namespace vir::mission {
namespace {

/// So many loops that change little are worth a solution together.
constexpr std::size_t kLoopsTogether = 20;
/// Below, the path is taken for better than it states.
constexpr double kAsStated = 0.1;
/// An accepted loop that is this far off (four degrees of freedom) is worth one alone.
constexpr double kPull = 9;

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("MissionGraph: " + what);
}

bool isPose(const Pose& T) { return isFinite(T) && std::abs(T.q.norm() - 1) < 1e-3; }

}  // namespace

void GraphOptions::validate() const { checkBounds(*this); }

void describe(OptionVisitor& v, GraphOptions& o) {
  v.section("Mission", "The whole path as a graph, which loops correct");
  v.value("drift_m_per_sqrt_m", o.drift_m_per_sqrt_m, {1e-4, 10.0},
          "what odometry of unknown accuracy drifts by [m] on the root of a metre");
  v.value("drift_rad_per_sqrt_m", o.drift_rad_per_sqrt_m, {1e-5, 1.0}, "likewise its heading");
  v.value("loop_sigma_m", o.loop_sigma_m, {1e-4, 10.0},
          "errors that a loop has beside those it knows of [m]");
  v.value("loop_sigma_rad", o.loop_sigma_rad, {1e-5, 1.0}, "likewise of the heading");
  v.value("lost_m", o.lost_m, {0.01, 1e4},
          "after a loss of vision the robot may be off by this [m]");
  v.value("lost_mps", o.lost_mps, {0.0, 1e3}, "and this per second of the loss");
  v.value("gate", o.gate, {1.0, 1e3},
          "chi-square of four degrees of freedom above which a loop contradicts the path");
  v.value("second_opinion", o.second_opinion, {1.0, 1e3},
          "up to this times the gate a loop waits for others that say the same");
  v.value("opinion_m", o.opinion_m, {0.0, 1e3}, "which are seen so far from one another [m]");
  v.value("iterations", o.iterations, {1, 100}, "of a solution");
}

const char* name(LoopState state) {
  switch (state) {
    case LoopState::accepted:
      return "accepted";
    case LoopState::waiting:
      return "waiting";
    case LoopState::refused:
      return "refused";
    default:
      return "taken back";
  }
}

void GraphNode::set(const LevelTransform& T) {
  for (int i = 0; i < 3; ++i) x[i] = T.t_m[i];
  x[3] = T.yaw_rad;
}

LevelTransform GraphNode::correction() const {
  return {x[3], position() - rotZ(x[3]) * path.T_W_B.p};
}

MissionGraph::MissionGraph(const GraphOptions& options) {
  options.validate();
  impl_ = std::make_unique<Impl>(options);
}
MissionGraph::~MissionGraph() = default;
MissionGraph::MissionGraph(MissionGraph&&) noexcept = default;
MissionGraph& MissionGraph::operator=(MissionGraph&&) noexcept = default;

int MissionGraph::Impl::find(std::uint64_t id) const {
  const auto it =
      std::lower_bound(nodes.begin(), nodes.end(), id,
                       [](const GraphNode& n, std::uint64_t value) { return n.path.id < value; });
  if (it == nodes.end() || it->path.id != id) return -1;
  return static_cast<int>(it - nodes.begin());
}

void MissionGraph::addFixed(std::uint64_t id, TimeNs t, const Pose& T_M_B) {
  Impl& g = *impl_;
  require(g.nodes.empty() || g.nodes.back().fixed, "a map's keyframe after those of the run");
  require(g.nodes.empty() || id > g.nodes.back().path.id, "ids must rise");
  require(isPose(T_M_B), "a map's keyframe without a pose");
  GraphNode node;
  node.path.id = id;
  node.path.t = t;
  node.path.T_W_B = T_M_B;
  node.fixed = true;
  node.set({0, T_M_B.p});
  g.nodes.push_back(node);
  g.factor.reset();
}

void MissionGraph::add(const PathNode& path) {
  Impl& g = *impl_;
  require(isPose(path.T_W_B) && path.covariance.allFinite(), "a keyframe that is not finite");
  GraphNode node;
  node.path = path;
  node.set({0, path.T_W_B.p});
  if (!g.nodes.empty()) {
    const GraphNode& before = g.nodes.back();
    require(path.id > before.path.id, "ids must rise");
    require(before.fixed || path.t > before.path.t, "stamps must rise");
    const bool followed = !before.fixed && before.path.segment == path.segment;
    node.stretch = before.stretch + (followed ? 0 : 1);
    if (!before.fixed) {
      node.step = followed ? followedNoise(before.path, path, g.options)
                           : lostNoise(before.path, path, g.options);
      const LevelTransform T_M_W = before.correction();
      node.set(T_M_W * LevelTransform{0, path.T_W_B.p});
    }
  }
  g.nodes.push_back(node);
}

void MissionGraph::move(std::uint64_t id, const Pose& T_W_B,
                        const std::optional<Odometry>& odometry) {
  Impl& g = *impl_;
  const int at = g.find(id);
  if (at < 0 || g.nodes[at].fixed || !isPose(T_W_B)) return;
  GraphNode& node = g.nodes[at];
  const LevelTransform T_M_W = node.correction();
  node.path.T_W_B = T_W_B;
  if (odometry && isPose(odometry->T_O_B) && odometry->variance.allFinite()) {
    node.odometry = odometry;
  }
  node.set(T_M_W * LevelTransform{0, T_W_B.p});
  g.factor.reset();
}

bool MissionGraph::Impl::followsOdometry(std::size_t at) const {
  const bool loops_act =
      std::any_of(weights.begin(), weights.end(), [](double w) { return w > 0; });
  if (!odometry_taken || !loops_act || at == 0) return false;
  const GraphNode &before = nodes[at - 1], &node = nodes[at];
  return node.path.pivots && before.odometry && node.odometry && before.stretch == node.stretch;
}

LevelTransform MissionGraph::Impl::stepOf(std::size_t at) const {
  const GraphNode &before = nodes[at - 1], &node = nodes[at];
  if (!followsOdometry(at)) return {0, node.path.T_W_B.p - before.path.T_W_B.p};
  const Pose T = before.odometry->T_O_B.inverse() * node.odometry->T_O_B;
  const Mat3 R_before = before.path.T_W_B.R();
  return {nearestYaw(R_before * T.R() * node.path.T_W_B.R().transpose()), R_before * T.p};
}

void MissionGraph::takeOdometry() {
  Impl& g = *impl_;
  g.odometry_taken = std::any_of(g.nodes.begin(), g.nodes.end(), [](const GraphNode& n) {
    return n.path.pivots && n.odometry.has_value();
  });
  if (!g.odometry_taken) return;
  g.scale = std::min(g.scale, 1.0);
  for (std::size_t at = 1; at < g.nodes.size(); ++at) {
    if (!g.followsOdometry(at)) continue;
    GraphNode& node = g.nodes[at];
    const Odometry& before = *g.nodes[at - 1].odometry;
    const Eigen::Vector4d grown = node.odometry->variance - before.variance;
    node.step.tie.setZero();
    if (!(grown.minCoeff() > 0)) continue;
    node.step.way = odometryNoise(g.nodes[at - 1].path, node.path, grown, g.options);
  }
  g.factor.reset();
}

LoopState MissionGraph::offer(const Loop& loop) {
  Impl& g = *impl_;
  JudgedLoop judged;
  judged.loop = loop;
  judged.state = g.judge(&judged);
  g.loops.push_back(judged);
  g.weights.push_back(0);
  const std::size_t at = g.loops.size() - 1;
  if (judged.state == LoopState::accepted) g.accept(at);
  if (judged.state != LoopState::waiting) return judged.state;
  const std::vector<std::size_t> others = g.seconding(loop);
  // Where nothing tied the two, any pose was possible: one that agrees is enough. Against the path
  // two are needed.
  const std::size_t needed = judged.chi2 < g.options.gate ? 1 : 2;
  if (others.size() < needed) return judged.state;
  g.accept(at);
  for (const std::size_t other : others) g.accept(other);
  return LoopState::accepted;
}

bool MissionGraph::solveDue() const {
  const Impl& g = *impl_;
  if (g.joined_anew || g.unsolved >= kLoopsTogether) return true;
  std::size_t left = g.unsolved;
  for (auto it = g.loops.rbegin(); it != g.loops.rend() && left > 0; ++it) {
    if (it->state != LoopState::accepted) continue;
    --left;
    if (g.residualOf(*it) > kPull) return true;
  }
  return false;
}

void MissionGraph::solve() {
  Impl& g = *impl_;
  g.unsolved = 0;
  g.joined_anew = false;
  if (g.nodes.empty() || g.nodes.back().fixed) return;
  // Loops are judged by variances as they are stated: a path that is held too fast would throw out
  // those that say so.
  const double weighed = std::exchange(g.scale, 1.0);
  g.minimise(g.options.iterations);
  g.decideOnLoops();
  g.scale = weighed;
  g.weigh();
  g.factor.reset();
  g.remember();
}

void MissionGraph::Impl::remember() {
  newest.reset();
  const bool acts = std::any_of(loops.begin(), loops.end(),
                                [](const JudgedLoop& l) { return l.state == LoopState::accepted; });
  newest_at = nodes.size() - 1;
  // A path that is better than its loops was left where it is, and so is its covariance.
  if (!acts || scale < kAsStated || !tied(0, static_cast<int>(newest_at))) return;
  newest = relative(0, static_cast<int>(newest_at));
  if (newest && !nodes.front().fixed) {
    newest->P += levelCovariance(nodes.front().path.covariance, nodes.front().path.T_W_B.R());
  }
}

std::optional<Eigen::Matrix4d> MissionGraph::covariance() const {
  const Impl& g = *impl_;
  if (!g.newest || g.nodes.back().stretch != g.nodes[g.newest_at].stretch) return std::nullopt;
  const LevelGuess now = *g.newest * g.along(g.newest_at, g.nodes.size() - 1);
  return now.P;
}

bool MissionGraph::empty() const { return impl_->nodes.empty(); }

LevelTransform MissionGraph::correction() const {
  const std::vector<GraphNode>& nodes = impl_->nodes;
  return nodes.empty() || nodes.back().fixed ? LevelTransform{} : nodes.back().correction();
}

LevelTransform MissionGraph::correctionAt(TimeNs t) const {
  const std::vector<GraphNode>& nodes = impl_->nodes;
  const auto first =
      std::find_if(nodes.begin(), nodes.end(), [](const auto& n) { return !n.fixed; });
  if (first == nodes.end()) return {};
  const auto after = std::lower_bound(
      first, nodes.end(), t, [](const GraphNode& n, TimeNs value) { return n.path.t < value; });
  if (after == nodes.end()) return nodes.back().correction();
  if (after == first) return first->correction();
  const GraphNode& a = *std::prev(after);
  if (a.stretch != after->stretch) {
    return t >= after->path.segment_since ? after->correction() : a.correction();
  }
  const double part = toSeconds(t - a.path.t) / toSeconds(after->path.t - a.path.t);
  // At the place between the two: a turn about an origin far away would move it.
  const Vec3 p_W = (1 - part) * a.path.T_W_B.p + part * after->path.T_W_B.p;
  const double yaw = (1 - part) * a.x[3] + part * after->x[3];
  const Vec3 p_M = (1 - part) * a.position() + part * after->position();
  return {yaw, p_M - rotZ(yaw) * p_W};
}

std::vector<StampedPose> MissionGraph::path() const {
  std::vector<StampedPose> out;
  for (const GraphNode& n : impl_->nodes) {
    if (!n.fixed) out.push_back({n.path.t, n.T_M_B()});
  }
  return out;
}

std::optional<Pose> MissionGraph::poseOf(std::uint64_t id) const {
  const int at = impl_->find(id);
  if (at < 0) return std::nullopt;
  return impl_->nodes[at].T_M_B();
}

bool MissionGraph::joined() const {
  const Impl& g = *impl_;
  return g.nodes.empty() || g.tied(0, static_cast<int>(g.nodes.size()) - 1);
}

std::optional<MissionGraph::Relative> MissionGraph::relative(std::uint64_t older,
                                                             std::uint64_t newer) const {
  Impl& g = *impl_;
  const int a = g.find(older), b = g.find(newer);
  if (a < 0 || b < 0 || !g.tied(a, b)) return std::nullopt;
  const auto found = g.relative(a, b);
  if (!found) return std::nullopt;
  return Relative{found->T.t_m, found->T.yaw_rad, found->P};
}

const std::vector<JudgedLoop>& MissionGraph::loops() const { return impl_->loops; }

LoopCounts MissionGraph::counts() const {
  LoopCounts out;
  for (const JudgedLoop& l : impl_->loops) {
    switch (l.state) {
      case LoopState::accepted:
        ++out.accepted;
        break;
      case LoopState::waiting:
        ++out.waiting;
        break;
      case LoopState::refused:
        ++out.refused;
        break;
      default:
        ++out.taken_back;
    }
  }
  return out;
}

}  // namespace vir::mission
