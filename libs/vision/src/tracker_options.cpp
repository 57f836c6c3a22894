#include "vir/core/option_check.h"
#include "vir/vision/feature_tracker.h"

namespace vir::vision {

void describe(OptionVisitor& v, TrackerOptions& o) {
  v.section("Tracker", "Front end: corners on a grid, followed by pyramidal Lucas-Kanade");
  v.value("max_tracks", o.max_tracks, {8, 5000}, "features followed at once");
  v.value("min_distance_px", o.min_distance_px, {3.0, 1000.0},
          "distance of a new corner to others");
  v.value("grid_cell_px", o.grid_cell_px, {10, 2000}, "edge of the cells corners are spread over");
  v.value("pyramid_levels", o.pyramid_levels, {1, 8}, "image halvings above full resolution");
  v.value("window_px", o.window_px, {7, 61}, "edge of the patch that finds the way");
  v.value("patch_px", o.patch_px, {7, 61}, "edge of the patch that fixes the position");
  v.value("max_iterations", o.max_iterations, {1, 100}, "Lucas-Kanade steps per pyramid level");
  v.value("forward_backward_px", o.forward_backward_px, {0.0, 100.0},
          "largest distance after following a feature back again; 0 = no check");
  v.value("outlier_px", o.outlier_px, {0.1, 100.0},
          "largest distance from the epipolar line of the common motion");
  v.value("min_corner_score", o.min_corner_score, {0.0, 1e6},
          "smaller eigenvalue of the mean gradient tensor [(grey levels/pixel)^2] a corner needs");
  v.value("min_similarity", o.min_similarity, {0.0, 1.0},
          "normalised cross-correlation with the remembered patch below which a track ends");
}

void TrackerOptions::validate() const {
  checkBounds(*this);
  if (patch_px % 2 == 0) {
    refuseSetting("Tracker", "patch_px", std::to_string(patch_px),
                  "a patch has a pixel in its middle; allowed: an odd number");
  }
}

}  // namespace vir::vision
