#include "vir/rawlog/mrpt_camera.h"

#include <algorithm>

namespace vir::rawlog {
namespace {

constexpr const char* kDoubleSphere = " model=double_sphere";
constexpr const char* kOmni = " model=omni";

bool endsIn(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

}  // namespace

CameraCalibration fromMrptCamera(const mrpt::img::TCamera& c) {
  CameraCalibration out;
  out.width = static_cast<int>(c.ncols);
  out.height = static_cast<int>(c.nrows);
  out.fx = c.fx();
  out.fy = c.fy();
  out.cx = c.cx();
  out.cy = c.cy();
  if (c.distortion == mrpt::img::DistortionModel::kannala_brandt) {
    out.distortion = Distortion::equidistant;
    out.dist = {c.k1(), c.k2(), c.k3(), c.k4()};
  } else if (c.distortion == mrpt::img::DistortionModel::plumb_bob) {
    const bool denominator = c.k4() != 0 || c.k5() != 0 || c.k6() != 0;
    out.distortion = denominator ? Distortion::rational : Distortion::radtan;
    out.dist = {c.k1(), c.k2(), c.p1(), c.p2(), c.k3(), c.k4(), c.k5(), c.k6()};
  } else if (endsIn(c.cameraName, kDoubleSphere) || endsIn(c.cameraName, kOmni)) {
    out.distortion = endsIn(c.cameraName, kOmni) ? Distortion::omni : Distortion::double_sphere;
    out.dist = c.dist;
  }
  return out;
}

mrpt::img::TCamera toMrptCamera(const CameraCalibration& c, const std::string& name) {
  mrpt::img::TCamera out;
  out.ncols = static_cast<uint32_t>(c.width);
  out.nrows = static_cast<uint32_t>(c.height);
  out.cameraName = name;
  out.setIntrinsicParamsFromValues(c.fx, c.fy, c.cx, c.cy);
  const auto& d = c.dist;
  switch (c.distortion) {
    case Distortion::none:
      break;
    case Distortion::radtan:
      out.setDistortionPlumbBob(d[0], d[1], d[2], d[3], d[4]);
      break;
    case Distortion::rational:
      out.distortion = mrpt::img::DistortionModel::plumb_bob;
      out.dist = d;
      break;
    case Distortion::equidistant:
      out.setDistortionKannalaBrandt(d[0], d[1], d[2], d[3]);
      break;
    case Distortion::double_sphere:
    case Distortion::omni:
      out.dist = d;
      out.cameraName += c.distortion == Distortion::omni ? kOmni : kDoubleSphere;
      break;
  }
  return out;
}

std::string nameOf(const mrpt::img::TCamera& camera) {
  for (const std::string end : {kDoubleSphere, kOmni}) {
    if (endsIn(camera.cameraName, end)) {
      return camera.cameraName.substr(0, camera.cameraName.size() - end.size());
    }
  }
  return camera.cameraName;
}

}  // namespace vir::rawlog
