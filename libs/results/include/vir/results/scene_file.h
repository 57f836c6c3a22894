#pragma once
/// Paths, anchors and map points as a 3-D scene that MRPT's SceneViewer3D shows.
#include <optional>
#include <string>
#include <vector>

#include "vir/evaluation/figure.h"
#include "vir/evaluation/trajectory.h"
#include "vir/roles/estimator.h"
#include "vir/types/loop_record.h"

namespace vir::results {

/// One robot in one world. Everything is moved by `T`.
struct SceneRobot {
  std::string name;  ///< shown at its path's beginning; may be empty
  evaluation::Color color;
  Pose T;
  Trajectory path;
  std::vector<Anchor> anchors;  ///< with ellipsoids of two standard deviations
  std::vector<Landmark> landmarks;
  Trajectory truth = {};                   ///< in the robot's world; gray
  std::optional<Calibration> camera = {};  ///< shown at some 30 places of the path
  std::vector<LoopRecord> loops = {};      ///< accepted ones are shown as lines
};

/// Writes a .3Dscene file (MRPT's serialised COpenGLScene, compressed). What is not finite is left
/// out; an ellipsoid's half axes are shown between 1 cm and 5 m. Throws std::runtime_error naming
/// the file if it cannot be written.
void writeScene(const std::string& file, const std::vector<SceneRobot>& robots);

}  // namespace vir::results
