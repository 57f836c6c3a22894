#include "vir/formats/lens_names.h"

namespace vir::formats {

ListedLens listedLens(const CameraCalibration& camera) {
  const auto d = camera.dist.begin();
  switch (camera.distortion) {
    case Distortion::none:
      break;
    case Distortion::radtan:
      return {"pinhole", {}, "radtan", {d, d + (d[4] != 0 ? 5 : 4)}};
    case Distortion::equidistant:
      return {"pinhole", {}, "equidistant", {d, d + 4}};
    case Distortion::rational:
      return {"pinhole", {}, "rational_polynomial", {d, d + 8}};
    case Distortion::double_sphere:
      return {"ds", {d[0], d[1]}, "none", {}};
    case Distortion::omni:
      return {"omni", {d[0]}, "radtan", {d + 1, d + 5}};
  }
  return {"pinhole", {}, "none", {}};
}

}  // namespace vir::formats
