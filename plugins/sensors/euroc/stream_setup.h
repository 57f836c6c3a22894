#pragma once
/// What settings and the first images say of how a stream is to be read.
#include "euroc_options.h"
#include "recording.h"

namespace vir::euroc {

Units unitsOf(const EurocOptions& o);

/// Looks at some images: stretch of 16 bits, and intrinsics for images of another size than the
/// calibration's. `wanted_width` is that after resizing; 0: as they are.
void fitToImages(int wanted_width, CameraStream* camera, ProblemLog* log);

}  // namespace vir::euroc
