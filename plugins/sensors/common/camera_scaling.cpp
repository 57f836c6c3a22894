#include "camera_scaling.h"

namespace vir {

void scaleTo(int width, int height, CameraCalibration* c) {
  const double sx = static_cast<double>(width) / c->width;
  const double sy = static_cast<double>(height) / c->height;
  c->width = width;
  c->height = height;
  c->fx *= sx;
  c->fy *= sy;
  // The middle of the first pixel is (0, 0).
  c->cx = (c->cx + 0.5) * sx - 0.5;
  c->cy = (c->cy + 0.5) * sy - 0.5;
}

}  // namespace vir
