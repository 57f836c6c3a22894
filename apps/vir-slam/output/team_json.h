#pragma once
/// Where everybody of a team is, as a file and as a line of the stream (docs/team.md).
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vir/team/team_mapper.h"
#include "vir/types/state.h"

namespace vir::app {

struct RobotPlace {
  std::uint32_t id = 0;
  team::TeamPlace place;
  std::optional<StampedPose> told;  ///< its body in the common frame, when it last told
};

struct TeamState {
  TimeNs t = 0;  ///< 0: there was no pose yet
  std::uint32_t own = 0;
  std::optional<team::CommonFrame> frame;
  std::vector<RobotPlace> robots;  ///< by number, this one among them
  std::vector<std::pair<std::uint32_t, std::uint32_t>> left_out;  ///< pairs
};

/// Of some lines, for a file.
std::string teamJson(const TeamState& team);
/// {"type":"team",...}, on one line.
std::string teamLine(const TeamState& team);

}  // namespace vir::app
