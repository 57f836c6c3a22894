#include "setup/run_options.h"

namespace vir::app {

void describe(OptionVisitor& v, RunOptions& o) {
  v.section("Estimator", "Which estimator runs, on what, and how");
  v.value(
      "driver", o.driver,
      "Estimator plugin; `vir-slam plugins` lists them; auto: the one that finds all it needs in "
      "the recording");
  v.value("rawlog", o.rawlog, "Recording, relative to this file; --rawlog goes before it");
  v.value(
      "calibration", o.calibration,
      "Calibration that goes before the recording's, relative to this file; what is set here of "
      "IMU and camera goes before it; --calibration goes before all");
  v.value("start_offset_s", o.start_offset_s, {0, 1e9},
          "Leave out everything before the first image plus this");
  v.value("duration_s", o.duration_s, {0, 1e9},
          "and everything later than this after it; 0: nothing, up to the recording's end");
}

}  // namespace vir::app
