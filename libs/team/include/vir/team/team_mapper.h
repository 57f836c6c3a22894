#pragma once
/// Where everybody of a team is, in one frame that all share, while they work: from what each tells
/// of the pairs that it knows.
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "vir/core/time.h"
#include "vir/team/team_graph.h"

namespace vir::team {

/// A robot begins another world when it is started again (session) or its estimator begins anew.
struct WorldId {
  std::uint32_t robot = 0;
  std::uint64_t session = 0;
  std::uint32_t segment = 0;

  auto key() const { return std::tie(robot, session, segment); }
  bool operator==(const WorldId& o) const { return key() == o.key(); }
  bool operator<(const WorldId& o) const { return key() < o.key(); }
};

/// How another robot's world lies in that of who tells: p_own = T p_from.
struct ToldTransform {
  WorldId from;
  WorldTransform T_own_from;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();  ///< (yaw, x, y, z) [rad, m]
};

/// The frame that a team shares, as one of its robots holds it.
struct CommonFrame {
  WorldId founder;         ///< in whose world it began, at its origin
  TimeNs founded = 0;      ///< when
  TimeNs held_since = 0;   ///< by who tells, in its present world
  WorldTransform T_C_own;  ///< p_common = T p_own
};

/// What a robot tells the others of the team, once in a while.
struct TeamTold {
  std::optional<CommonFrame> frame;  ///< none before its first pose
  std::vector<ToldTransform> transforms;
};
/// More are not told.
constexpr std::size_t kMostToldTransforms = 32;

/// Of a robot that is tied to this one, directly or by others.
struct TeamPlace {
  WorldId world;
  WorldTransform T_C_world;                              ///< to the common frame
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< against this robot (yaw, x, y, z)
};

/// All robots that hear the same come to the same map. Of the frames that those who are tied
/// together hold, they take that of the lowest founder's number, and of those the oldest: a robot
/// that is started again founds a younger one, and takes over the old one as soon as it is tied to
/// somebody who holds it. Where the founder's world is there, it is the common frame; else the
/// frame stays where the one that has held it longest has it. Memory is bounded: the newest of each
/// robot, 32 robots.
class TeamMapper {
 public:
  /// This robot's world, since it has a pose; another one than before begins anew. `t`: now.
  void setOwn(const WorldId& world, TimeNs t, std::vector<ToldTransform> transforms);
  /// In any order: what is older than what was heard before is left out.
  void hear(const WorldId& sender, TimeNs t, const TeamTold& told);
  /// Solves the graph of all pairs. What a robot told more than 30 s before `now` no longer counts.
  void solve(TimeNs now);

  /// To tell the others; as of the last solve().
  TeamTold told() const;
  /// This robot and all that are tied to it, by number; empty before the first pose.
  const std::map<std::uint32_t, TeamPlace>& places() const { return places_; }
  /// Pairs that contradict the others, by number.
  const std::vector<std::pair<std::uint32_t, std::uint32_t>>& leftOut() const { return left_out_; }
  const std::optional<CommonFrame>& frame() const { return frame_; }

 private:
  struct Heard {
    WorldId world;
    TimeNs t = 0;
    TeamTold told;
  };
  std::vector<TransformEdge> edges() const;
  void chooseFrame(const TeamGraph& graph, TimeNs now);

  std::optional<WorldId> own_;
  std::vector<ToldTransform> own_transforms_;
  std::map<std::uint32_t, Heard> heard_;
  std::optional<CommonFrame> frame_;
  std::map<std::uint32_t, TeamPlace> places_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> left_out_;
};

}  // namespace vir::team
