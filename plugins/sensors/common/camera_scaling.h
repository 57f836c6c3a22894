#pragma once
#include "vir/types/calibration.h"

namespace vir {

/// The intrinsics of images that are `width`x`height` instead.
void scaleTo(int width, int height, CameraCalibration* c);

}  // namespace vir
