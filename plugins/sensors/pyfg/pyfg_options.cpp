#include "pyfg_options.h"

namespace vir::pyfg {

void describe(OptionVisitor& v, PyfgOptions& o) {
  v.section("pyfg", "Factor graph in PyFG text: odometry, ranges and ground truth of one robot");
  v.value("source", o.source, "the file");
  v.value("robot", o.robot, "letter of the robot; empty = the only one there is");
  v.value("read_gt", o.read_gt, "take over the ground truth (evaluation only)");
  v.value("read_odometry", o.read_odometry, "take over the odometry");
  v.value("read_ranges", o.read_ranges, "take over the ranges to anchors");
  v.value("read_peer_ranges", o.read_peer_ranges, "take over the ranges to other robots");
  v.value("planar_sigma_z_m", o.planar.z_m, {0, 10},
          "standard deviation of the height a planar motion leaves out, per motion");
  v.value("planar_sigma_tilt_rad", o.planar.tilt_rad, {0, 3},
          "standard deviation of roll and pitch a planar motion leaves out, per motion");
}

}  // namespace vir::pyfg
