#pragma once
/// One line of a PyFG text file (the format of PyFactorGraph): what it says, or why it cannot be
/// used. Fields are separated by blanks, angles in rad, lengths in m, stamps in decimal seconds.
#include <Eigen/Core>
#include <string>
#include <string_view>
#include <tuple>
#include <variant>

#include "vir/core/time.h"
#include "vir/geometry/pose.h"

namespace vir::pyfg {

using Mat6 = Eigen::Matrix<double, 6, 6>;

/// A letter and a number: "A12" is pose 12 of robot A, "L0" landmark 0.
struct Name {
  char letter = 0;
  int number = 0;

  bool operator<(const Name& o) const {
    return std::tie(letter, number) < std::tie(o.letter, o.number);
  }
  bool operator==(const Name& o) const { return letter == o.letter && number == o.number; }
};
std::string toString(const Name& name);

/// `VERTEX_SE3:QUAT t name x y z qx qy qz qw`, `VERTEX_SE2 t name x y theta`: the true pose.
struct Vertex {
  TimeNs t = 0;
  Name name;
  Pose T_W_B;  ///< z, roll and pitch of a planar one are 0
};

/// `EDGE_SE3:QUAT t from to x y z qx qy qz qw c11 c12 .. c66` (upper triangle of the covariance of
/// x y z and the rotation), `EDGE_SE2 t from to x y theta c11 c12 .. c33`: measured motion.
struct MotionEdge {
  TimeNs t = 0;
  Name from, to;
  Pose T_from_to;
  /// Of (translation in `from`, rotation on the right); zero if the file's is no covariance.
  Mat6 covariance = Mat6::Zero();
  bool covariance_usable = true;
  bool planar = false;  ///< z, roll and pitch are not measured: 0, with variance 0
};

/// `EDGE_RANGE t a b metres variance`.
struct RangeEdge {
  TimeNs t = 0;
  Name a, b;
  double range_m = 0, variance = 0;
};

/// `VERTEX_XYZ [t] name x y z`, `VERTEX_XY [t] name x y`: where a landmark truly is.
struct Landmark {
  Name name;
  Vec3 p_W = Vec3::Zero();
  bool planar = false;
};

using Line = std::variant<Vertex, MotionEdge, RangeEdge, Landmark>;

/// Why a line is not used.
struct LineFault {
  std::string kind;  ///< name of the counter, e.g. "line_malformed"
  std::string text;
};

/// False with the fault filled in when the line is not exactly as above: unknown keyword, wrong
/// number of fields, not a number, not finite, beyond what a robot can do, a quaternion that is
/// off unit length by more than 0.01, a variance that is not above 0.
bool parseLine(std::string_view text, Line* line, LineFault* fault);

}  // namespace vir::pyfg
