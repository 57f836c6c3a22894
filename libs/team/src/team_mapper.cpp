#include "vir/team/team_mapper.h"

#include <algorithm>

namespace vir::team {
namespace {

constexpr std::size_t kMostRobots = 32;
constexpr TimeNs kForgotten = 30'000'000'000;

std::string nameOf(std::uint32_t robot) { return std::to_string(robot); }
std::uint32_t numberOf(const std::string& name) {
  return static_cast<std::uint32_t>(std::stoul(name));
}

/// Goes before another frame.
bool before(const CommonFrame& a, const CommonFrame& b) {
  return std::tie(a.founder.robot, a.founded, a.founder) <
         std::tie(b.founder.robot, b.founded, b.founder);
}

}  // namespace

void TeamMapper::setOwn(const WorldId& world, TimeNs t, std::vector<ToldTransform> transforms) {
  if (!own_ || !(*own_ == world)) {
    own_ = world;
    frame_ = CommonFrame{world, t, t, {}};
    places_.clear();
  }
  own_transforms_ = std::move(transforms);
  if (own_transforms_.size() > kMostToldTransforms) own_transforms_.resize(kMostToldTransforms);
}

void TeamMapper::hear(const WorldId& sender, TimeNs t, const TeamTold& told) {
  const auto known = heard_.find(sender.robot);
  if (known == heard_.end() && heard_.size() >= kMostRobots) return;
  if (known != heard_.end() && known->second.t >= t) return;
  Heard& h = heard_[sender.robot];
  h = {sender, t, told};
  if (h.told.transforms.size() > kMostToldTransforms) {
    h.told.transforms.resize(kMostToldTransforms);
  }
}

/// Of a pair both robots tell: from the same ranges, so that one counts, the lower number's.
std::vector<TransformEdge> TeamMapper::edges() const {
  std::vector<TransformEdge> out;
  const auto current = [&](const WorldId& w) {
    if (w.robot == own_->robot) return w == *own_;
    const auto h = heard_.find(w.robot);
    return h != heard_.end() && h->second.world == w;
  };
  const auto append = [&](const WorldId& teller, const std::vector<ToldTransform>& transforms) {
    for (const ToldTransform& t : transforms) {
      if (!current(t.from)) continue;
      out.push_back({nameOf(t.from.robot), nameOf(teller.robot), t.T_own_from, t.covariance});
    }
  };
  bool own_done = false;
  for (const auto& [robot, h] : heard_) {
    if (!own_done && own_->robot < robot) {
      append(*own_, own_transforms_);
      own_done = true;
    }
    append(h.world, h.told.transforms);
  }
  if (!own_done) append(*own_, own_transforms_);
  return out;
}

void TeamMapper::solve(TimeNs now) {
  for (auto it = heard_.begin(); it != heard_.end();) {
    it = it->second.t < now - kForgotten ? heard_.erase(it) : std::next(it);
  }
  if (!own_) return;
  const TeamGraph graph = solveTeam(nameOf(own_->robot), edges());
  chooseFrame(graph, now);
  places_.clear();
  for (const auto& [name, world] : graph.worlds) {
    const std::uint32_t robot = numberOf(name);
    places_[robot] = {robot == own_->robot ? *own_ : heard_.at(robot).world,
                      frame_->T_C_own * world.T_root, world.covariance};
    places_[robot].T_C_world.yaw_rad = wrapAngle(places_[robot].T_C_world.yaw_rad);
  }
  left_out_.clear();
  for (const TransformEdge& e : graph.left_out) {
    left_out_.emplace_back(std::minmax(numberOf(e.from), numberOf(e.to)));
  }
}

void TeamMapper::chooseFrame(const TeamGraph& graph, TimeNs now) {
  CommonFrame chosen = *frame_;
  for (const auto& [name, world] : graph.worlds) {
    const auto h = heard_.find(numberOf(name));
    if (h == heard_.end() || !h->second.told.frame) continue;
    if (before(*h->second.told.frame, chosen)) {
      chosen = *h->second.told.frame;
      chosen.held_since = now;
    }
  }
  const auto same = [&](const CommonFrame& f) {
    return f.founder == chosen.founder && f.founded == chosen.founded;
  };
  if (same(*frame_)) chosen = *frame_;
  const bool founder_is_here =
      chosen.founder == *own_ || (graph.worlds.count(nameOf(chosen.founder.robot)) > 0 &&
                                  heard_.count(chosen.founder.robot) > 0 &&
                                  heard_.at(chosen.founder.robot).world == chosen.founder);
  if (founder_is_here) {
    chosen.T_C_own = graph.worlds.at(nameOf(chosen.founder.robot)).T_root.inverse();
  } else {
    // Who has held it longest, and of those the lowest number; this robot only if it did before.
    using Holder = std::pair<TimeNs, std::uint32_t>;
    std::optional<Holder> longest;
    if (same(*frame_)) longest = Holder(frame_->held_since, own_->robot);
    for (const auto& [name, world] : graph.worlds) {
      const auto h = heard_.find(numberOf(name));
      if (h == heard_.end() || !h->second.told.frame || !same(*h->second.told.frame)) continue;
      const CommonFrame& f = *h->second.told.frame;
      const Holder holder(f.held_since, h->first);
      if (longest && !(holder < *longest)) continue;
      longest = holder;
      chosen.T_C_own = f.T_C_own * world.T_root.inverse();
    }
  }
  chosen.T_C_own.yaw_rad = wrapAngle(chosen.T_C_own.yaw_rad);
  frame_ = chosen;
}

TeamTold TeamMapper::told() const { return {frame_, own_transforms_}; }

}  // namespace vir::team
