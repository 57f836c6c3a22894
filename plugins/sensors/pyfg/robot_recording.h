#pragma once
/// What one robot of a graph saw, in time order.
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "pyfg_options.h"

namespace vir::pyfg {

struct TruePose {
  Pose T_W_B;
};

struct AnchorRange {
  int anchor = 0;  ///< number of the landmark
  double range_m = 0, sigma_m = 0;
};

struct PeerRange {
  int peer = 0;  ///< see robotId()
  double range_m = 0, sigma_m = 0;
};

struct Event {
  TimeNs t = 0;
  std::variant<TruePose, OdometryPose, AnchorRange, PeerRange> what;
};

/// Number of a robot: its place in the alphabet, A and a = 0 ... Z and z = 25.
int robotId(char letter);

struct RobotRecording {
  char robot = 0;
  std::vector<Event> events;        ///< in time order; at one time truth, odometry, ranges
  std::vector<Landmark> landmarks;  ///< ordered by name
  std::vector<char> peers;          ///< robots it has ranges to, in alphabetical order
};

/// Throws SettingsError if the robot asked for is not in the graph, or none is asked for and there
/// are several; the text lists the letters.
RobotRecording extractRobot(const Graph& graph, const PyfgOptions& options, ProblemLog* log);

}  // namespace vir::pyfg
