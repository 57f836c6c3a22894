#pragma once
/// Nodes of the long window that are difficult for factors.
#include <cmath>
#include <string>
#include <vector>

namespace vir::factors::test {

struct NamedNode {
  std::string name;
  std::vector<double> x;
};

/// Places, headings around half a turn, and scales.
inline std::vector<NamedNode> difficultNodes() {
  return {{"origin", {0, 0, 0, 0, 0}},
          {"yaw just below pi", {1, -2, 0.5, M_PI - 1e-4, 0.1}},
          {"yaw just above -pi", {-3, 1, 2, -M_PI + 1e-4, -0.2}},
          {"many turns", {4, 5, -1, 7 * M_PI + 0.3, 0.05}},
          {"quarter turn, odometry far too long", {-2, -2, 0, M_PI / 2, 0.7}},
          {"far away", {300, -200, 40, 2.5, -0.1}}};
}

}  // namespace vir::factors::test
