#include "vir/core/option_check.h"
#include "vir/mission/loop_closer.h"

namespace vir::mission {

void describe(OptionVisitor& v, LoopOptions& o) {
  v.section("Loops", "Second visits that may be believed");
  v.value("interval_s", o.interval_s, {0.0, 60.0}, "keyframes are remembered this far apart");
  v.value("moved_m", o.moved_m, {0.0, 100.0}, "and where the robot has moved by this");
  v.value("turned_rad", o.turned_rad, {0.0, 3.0}, "or turned by this");
  v.value("pause_m", o.pause_m, {0.0, 1000.0},
          "after a loop none is looked for on so much of the way (3 s at most)");
  v.value("max_landmark_sigma", o.max_landmark_sigma, {1e-3, 1.0},
          "relative accuracy of distances that count as map points");
  describe(v, o.finder);
  describe(v, o.describer);
  describe(v, o.index);
  describe(v, o.verify);
  describe(v, o.graph);
}

void LoopOptions::validate() const { checkBounds(*this); }

}  // namespace vir::mission
