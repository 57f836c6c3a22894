#include <algorithm>
#include <cmath>

#include "graph_state.h"

namespace vir::mission {
namespace {

/// Gravity is known to this [rad] at either keyframe together; a loop that wants them turned more
/// is of another place.
constexpr double kTiltSigma = 0.01;
constexpr double kTiltGate = 3.5;
/// Loops that wait are asked newest first, no more than so many.
constexpr std::size_t kAsked = 60;
/// Ways that are told of with another sign or length than a loop can have.
constexpr double kLongest = 1e6;  // [m]

bool isLoop(const Loop& loop) {
  const auto& P = loop.covariance;
  return loop.T_older_newer.p.allFinite() && loop.T_older_newer.p.norm() < kLongest &&
         std::abs(loop.T_older_newer.q.norm() - 1) < 1e-3 && P.allFinite() &&
         P.diagonal().minCoeff() >= 0;
}

}  // namespace

LevelLoop MissionGraph::Impl::level(const Loop& loop) const {
  return levelLoop(loop, nodes[static_cast<std::size_t>(find(loop.older))].path.T_W_B,
                   nodes[static_cast<std::size_t>(find(loop.newer))].path.T_W_B, options);
}

LevelGuess MissionGraph::Impl::guess(const Loop& loop) const {
  const LevelLoop l = level(loop);
  return {{l.turn_rad, l.motion_W}, l.covariance};
}

LoopState MissionGraph::Impl::judge(JudgedLoop* judged) {
  const Loop& loop = judged->loop;
  const int older = find(loop.older), newer = find(loop.newer);
  if (older < 0 || newer < 0 || older >= newer || !isLoop(loop)) return LoopState::refused;
  const GraphNode &a = nodes[static_cast<std::size_t>(older)],
                  &b = nodes[static_cast<std::size_t>(newer)];
  judged->t_older = a.path.t;
  judged->t_newer = b.path.t;
  if (b.fixed) return LoopState::refused;
  const double rotation = loop.covariance.bottomRightCorner<3, 3>().trace();
  const LevelLoop l = level(loop);
  if (l.tilt_rad > kTiltGate * std::sqrt(kTiltSigma * kTiltSigma + rotation)) {
    return LoopState::refused;
  }
  const bool held = tied(older, newer);
  if (!held && a.fixed) return LoopState::waiting;  // a map: anywhere in it
  const auto known = relative(older, newer);
  if (!known) return LoopState::refused;
  judged->chi2 = chiSquare(*known, {{l.turn_rad, l.motion_W}, l.covariance});
  if (!(judged->chi2 <= options.gate * options.second_opinion)) return LoopState::refused;
  return held && judged->chi2 <= options.gate ? LoopState::accepted : LoopState::waiting;
}

std::vector<int> MissionGraph::Impl::groups() const {
  std::vector<int> group(nodes.empty() ? 0 : static_cast<std::size_t>(nodes.back().stretch) + 1);
  for (std::size_t i = 0; i < group.size(); ++i) group[i] = static_cast<int>(i);
  for (const JudgedLoop& l : loops) {
    if (l.state != LoopState::accepted) continue;
    const int a = group[static_cast<std::size_t>(
        nodes[static_cast<std::size_t>(find(l.loop.older))].stretch)];
    const int b = group[static_cast<std::size_t>(
        nodes[static_cast<std::size_t>(find(l.loop.newer))].stretch)];
    if (a == b) continue;
    std::replace(group.begin(), group.end(), std::max(a, b), std::min(a, b));
  }
  return group;
}

bool MissionGraph::Impl::tied(int older, int newer) const {
  const int a = nodes[static_cast<std::size_t>(older)].stretch,
            b = nodes[static_cast<std::size_t>(newer)].stretch;
  if (a == b) return true;
  const std::vector<int> group = groups();
  return group[static_cast<std::size_t>(a)] == group[static_cast<std::size_t>(b)];
}

bool MissionGraph::Impl::agree(const Loop& one, const Loop& other) {
  const int a = find(one.older), b = find(other.older), c = find(one.newer), d = find(other.newer);
  if (!tied(a, b) || !tied(c, d)) return false;
  const auto olders = relative(a, b), newers = relative(c, d);
  if (!olders || !newers) return false;
  return chiSquare(inverse(*olders) * guess(one) * *newers, guess(other)) <= options.gate;
}

bool MissionGraph::Impl::apart(const Loop& one, const Loop& other) const {
  const Vec3 way = nodes[static_cast<std::size_t>(find(one.newer))].path.T_W_B.p -
                   nodes[static_cast<std::size_t>(find(other.newer))].path.T_W_B.p;
  return way.norm() >= options.opinion_m;
}

std::vector<std::size_t> MissionGraph::Impl::seconding(const Loop& loop) {
  std::vector<std::size_t> out;
  const bool held = tied(find(loop.older), find(loop.newer));
  std::size_t asked = 0;
  for (std::size_t k = loops.size() - 1; k-- > 0 && asked < kAsked;) {
    if (loops[k].state != LoopState::waiting || loops[k].loop.newer == loop.newer) continue;
    ++asked;
    // Neighbours make the same mistake: against the path, opinions count from elsewhere only.
    if (held && !apart(loops[k].loop, loop)) continue;
    if (held && std::any_of(out.begin(), out.end(), [&](std::size_t other) {
          return !apart(loops[k].loop, loops[other].loop);
        })) {
      continue;
    }
    if (agree(loops[k].loop, loop)) out.push_back(k);
  }
  return out;
}

void MissionGraph::Impl::accept(std::size_t k) {
  const Loop& loop = loops[k].loop;
  if (!tied(find(loop.older), find(loop.newer))) {
    join(loop);
    joined_anew = true;
    factor.reset();
  }
  // Else what is known of the path stays as it was until the next solution: a factorisation per
  // loop costs more than what it would know better.
  loops[k].state = LoopState::accepted;
  weights[k] = 1;
  ++unsolved;
}

void MissionGraph::Impl::join(const Loop& loop) {
  const LevelLoop l = level(loop);
  const GraphNode& older = nodes[static_cast<std::size_t>(find(loop.older))];
  const GraphNode& newer = nodes[static_cast<std::size_t>(find(loop.newer))];
  const std::vector<int> group = groups();
  const int moves = group[static_cast<std::size_t>(newer.stretch)];
  const LevelTransform T =
      older.level() * LevelTransform{l.turn_rad, l.motion_W} * newer.level().inverse();
  for (GraphNode& n : nodes) {
    if (!n.fixed && group[static_cast<std::size_t>(n.stretch)] == moves) n.set(T * n.level());
  }
}

}  // namespace vir::mission
