#pragma once
/// From a robot's measured motions to the path its odometry reports.
#include <vector>

#include "graph.h"

namespace vir::pyfg {

/// Standard deviations, per motion, of what a planar motion does not measure.
struct PlanarSigmas {
  double z_m = 1e-3;
  double tilt_rad = 1e-3;
};

/// Variances of a motion that is missing in the file: nothing is known of it.
constexpr double kUnknownPositionVariance = 1e6;  // [m^2]
constexpr double kUnknownRotationVariance = 10;   // [rad^2]

/// A pose as odometry reports it.
struct OdometryPose {
  TimeNs t = 0;
  Pose T_O_B;  ///< O: where the first pose is (identity)
  /// Of the motion since the pose before this one in the list (zero for the first): position along
  /// the axes of O, rotation on the right. Zero where the file gives none.
  Mat6 step_covariance = Mat6::Zero();
};

/// The motions between successive poses of `robot`, put together from identity on. The motion to a
/// pose is the one from the nearest lower number; all others (loop closures) are counted and not
/// used. A pose bears the stamp of the motion that leads to it, the first one that of its vertex:
/// the motion's stamp is the odometry's own. Told in the log: poses whose predecessor has no motion
/// to them (a gap: the robot is taken to stay, with the unknown variances above), and stamps that
/// do not grow (the pose is left out, its motion goes into the next).
std::vector<OdometryPose> integrateOdometry(const Graph& graph, char robot,
                                            const PlanarSigmas& planar, ProblemLog* log);

}  // namespace vir::pyfg
