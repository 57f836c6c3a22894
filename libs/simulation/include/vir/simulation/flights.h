#pragma once
/// Made-up flights. The body's x axis looks ahead along the path, z is up; it leans into its
/// accelerations like a multirotor and sways a little like anything that flies or is carried.
#include <string>
#include <vector>

#include "vir/core/options.h"
#include "vir/simulation/motion.h"

namespace vir {

struct FlightOptions {
  double length_m = 120;  ///< of the path; shapes that close are repeated
  double speed_mps = 1.5;
  double rest_s = 1;      ///< standing still at both ends
  double sway_m = 0.04;   ///< standard deviation of the sway in position
  double sway_deg = 1.5;  ///< of the sway in roll, pitch and yaw
  double height_m = 0.8;  ///< amplitude of a slow change of height
  int seed = 1;           ///< of the sway
};
/// Section [Flight].
void describe(OptionVisitor& v, FlightOptions& o);

/// Names that `flight` knows: eight, corridor, route, standing.
std::vector<std::string> flightNames();

/// Starts at time 1 s at the origin. `eight`: a figure eight of 12 by 6 m. `corridor`: straight
/// ahead, a turn of 180 degrees, and back beside it. `route`: round a building floor with rooms,
/// 20 by 14 m. `standing`: stays for length_m / speed_mps. Throws std::invalid_argument for another
/// name.
Motion flight(const std::string& name, const FlightOptions& options);

/// Along straight lines between points (T_W_B positions), corners rounded over about a second.
Motion flyAlong(const std::vector<Vec3>& points, const FlightOptions& options);

}  // namespace vir
