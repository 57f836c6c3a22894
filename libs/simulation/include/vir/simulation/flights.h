#pragma once
/// Made-up flights. The body's x axis looks ahead along the path, z is up; it leans into its
/// accelerations like a multirotor and sways a little like anything that flies or is carried.
#include <string>
#include <vector>

#include "vir/core/options.h"
#include "vir/simulation/motion.h"

namespace vir::simulation {

struct FlightOptions {
  double length_m = 120;  ///< of the path; shapes that close are repeated
  double speed_mps = 1.5;
  double rest_s = 1;        ///< standing still at both ends
  double sway_m = 0.04;     ///< standard deviation of the sway in position
  double sway_deg = 1.5;    ///< of the sway in roll, pitch and yaw
  double height_m = 0.8;    ///< amplitude of a slow change of height
  double stop_every_m = 0;  ///< standing still after every so much of the way; 0 = never
  double stop_s = 4;        ///< for how long
  std::vector<double> start_m{0, 0, 0};  ///< where the path begins in W
  double start_heading_deg = 0;          ///< the whole path is turned about it
  int seed = 1;                          ///< of the sway
};
/// Section [Flight].
void describe(OptionVisitor& v, FlightOptions& o);

/// Names that `flight` knows.
std::vector<std::string> flightNames();

/// Starts at time 1 s. `eight`: a figure eight of 12 by 6 m. `corridor`: straight ahead, a turn of
/// 180 degrees, and back beside it. `route`: round a building floor with rooms, 20 by 14 m.
/// `helix`: circles of 3 m radius, up and down again by 4.8 m. `warehouse`: up and down five aisles
/// of 18 m. `letter_m`, `letter_i`, `letter_s`, `letter_t`: letters 8 m high on the ground, there
/// and back. `stop_and_go`: round a rectangle, standing still every 8 m. `standing`: stays for
/// length_m / speed_mps. Throws std::invalid_argument for another name.
Motion flight(const std::string& name, const FlightOptions& options);

/// Along straight lines between points (positions before start_m and start_heading_deg), corners
/// rounded over about a second.
Motion flyAlong(const std::vector<Vec3>& points, const FlightOptions& options);

}  // namespace vir::simulation
