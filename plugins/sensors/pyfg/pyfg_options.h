#pragma once
#include <string>

#include "odometry_chain.h"
#include "vir/core/options.h"

namespace vir::pyfg {

/// Settings of section [pyfg].
struct PyfgOptions {
  std::string source;  ///< the file
  std::string robot;   ///< letter; may be left out where the file has one robot only
  bool read_gt = true;
  bool read_odometry = true;
  bool read_ranges = true;       ///< to landmarks
  bool read_peer_ranges = true;  ///< to other robots
  PlanarSigmas planar;
};

void describe(OptionVisitor& v, PyfgOptions& o);

}  // namespace vir::pyfg
