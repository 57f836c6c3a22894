#pragma once
/// A small PyFG graph, written for a test.
#include <cstdio>
#include <string>

namespace vir::test {

constexpr const char* kPlanarCovariance = "0.04 0 0 0.09 0 0.01";
constexpr const char* kSpatialCovariance =
    "0.01 0 0 0 0 0 0.02 0 0 0 0 0.03 0 0 0 0.001 0 0 0.002 0 0.003";

inline std::string vertex2(char robot, int i, double t, double x, double y, double theta) {
  char line[160];
  std::snprintf(line, sizeof line, "VERTEX_SE2 %.6f %c%d %.9f %.9f %.9f\n", t, robot, i, x, y,
                theta);
  return line;
}

inline std::string motion2(char robot, int i, int j, double t, double x, double y, double theta) {
  char line[240];
  std::snprintf(line, sizeof line, "EDGE_SE2 %.6f %c%d %c%d %.9f %.9f %.9f %s\n", t, robot, i,
                robot, j, x, y, theta, kPlanarCovariance);
  return line;
}

inline std::string range(double t, const std::string& a, const std::string& b, double m) {
  char line[160];
  std::snprintf(line, sizeof line, "EDGE_RANGE %.6f %s %s %.9f 0.0025\n", t, a.c_str(), b.c_str(),
                m);
  return line;
}

/// Robots A and B on parallel lines 2 m apart, 1 m and 1 s per pose, heading +x; anchor L7. Per
/// pose: a range of each to the anchor, and one between the two, named in turns.
inline std::string twoRobots(int poses = 5) {
  std::string vertices, motions, ranges;
  for (int i = 0; i < poses; ++i) {
    for (const char robot : {'A', 'B'}) {
      const std::string name = robot + std::to_string(i);
      vertices += vertex2(robot, i, 100 + i, i, robot == 'A' ? 0 : 2, 0);
      if (i > 0) motions += motion2(robot, i - 1, i, 100 + i, 1, 0, 0);
      ranges += range(100.25 + i, name, "L7", 3 + i);
    }
    const std::string a = "A" + std::to_string(i), b = "B" + std::to_string(i);
    ranges += i % 2 == 0 ? range(100.5 + i, a, b, 2) : range(100.5 + i, b, a, 2);
  }
  return vertices + "VERTEX_XY L7 4.5 -1.5\n" + motions + ranges;
}

}  // namespace vir::test
