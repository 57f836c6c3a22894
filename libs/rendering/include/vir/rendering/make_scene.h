#pragma once
/// Makes up a place around the paths of robots.
#include <string>
#include <vector>

#include "vir/core/options.h"
#include "vir/rendering/scene.h"

namespace vir::rendering {

struct SceneOptions {
  /// `room`: one hall with furniture. `corridors`: everything farther from the paths than
  /// `corridor_half_width_m` is solid up to the ceiling.
  std::string layout = "room";
  double margin_m = 2.5;                ///< the room reaches this far beyond the paths
  double below_m = 1.2, above_m = 1.2;  ///< floor and ceiling from the lowest and highest pose
  double corridor_half_width_m = 1.5;
  double clearance_m = 0.6;  ///< nothing stands nearer to a path
  int boxes = 60;            ///< crates, cabinets, pillars and beams
  int seed = 1;
};
/// Section [Scene].
void describe(OptionVisitor& v, SceneOptions& o);

/// `paths`: positions in W that must stay free, a few per metre. `keep_clear`: further points (of
/// anchors) that no box may swallow. Throws std::invalid_argument for an empty path or an unknown
/// layout.
Scene makeScene(const SceneOptions& options, const std::vector<Vec3>& paths,
                const std::vector<Vec3>& keep_clear);

}  // namespace vir::rendering
