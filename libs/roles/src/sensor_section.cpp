#include "vir/roles/sensor_section.h"

#include <mrpt/obs/CObservationImage.h>
#include <mrpt/poses/CPose3D.h>

#include <algorithm>

#include "vir/core/angles.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/stereo_images.h"

namespace vir::roles {
namespace {

void declare(OptionVisitor& v, SensorSection& s) {
  v.section(s.name, "A sensor");
  v.value("driver", s.driver, "class of the sensor");
  v.value("process_rate", s.rate_hz, {1e-3, 1e5}, "calls of the driver per second [Hz]");
  v.value("optional", s.optional, "recording goes on without it if it is missing at the start");
  v.choice("clock", s.clock, {"auto", "keep", "device"},
           "its stamps: the host's unless far from it, as they are, or of a clock of its own");
  v.value("stamp_offset_s", s.stamp_offset_s, {-10, 10},
          "added to its stamps, e.g. -half exposure");
  v.value("intrinsics", s.intrinsics, 0, "fx fy cx cy [px], where the driver leaves them empty");
  v.choice("distortion", s.distortion, {"none", "radtan", "equidistant"}, "model of `dist`");
  v.value("dist", s.dist, 0, "k1 k2 p1 p2 [k3], or k1 k2 k3 k4 of equidistant");
  v.value("camera_pose", s.camera_pose, 0,
          "x y z [m] yaw pitch roll [deg] of the camera in the body");
  v.value("side_by_side", s.side_by_side,
          "its images hold the views of two cameras, CAM0 on the left and CAM1 on the right");
  v.value("right_intrinsics", s.right_intrinsics, 0,
          "of the right camera of two; empty: as `intrinsics`");
  v.value("right_dist", s.right_dist, 0, "of the right camera of two; empty: as `dist`");
  v.value("right_camera_pose", s.right_camera_pose, 0,
          "of the right camera of two in the body, as `camera_pose`");
}

void requireSize(const Settings& settings, const SensorSection& s, const char* key,
                 const std::vector<double>& values, std::size_t least, std::size_t most) {
  if (values.empty() || (values.size() >= least && values.size() <= most)) return;
  throw SettingsError(*settings.find(s.name, key), "needs " + std::to_string(least) + " numbers");
}

void requireFocalLengths(const Settings& settings, const SensorSection& s, const char* key,
                         const std::vector<double>& values) {
  if (values.empty() || (values[0] > 0 && values[1] > 0)) return;
  throw SettingsError(*settings.find(s.name, key), "fx and fy [px] must be above 0");
}

/// Lens and place of one camera as a section gives them.
struct GivenCamera {
  std::vector<double> intrinsics, dist, pose;
};

GivenCamera cameraOf(const SensorSection& s, bool right) {
  if (!right) return {s.intrinsics, s.dist, s.camera_pose};
  return {s.right_intrinsics.empty() ? s.intrinsics : s.right_intrinsics,
          s.right_dist.empty() ? s.dist : s.right_dist, s.right_camera_pose};
}

mrpt::img::TCamera withIntrinsics(const std::string& distortion, const GivenCamera& given,
                                  mrpt::img::TCamera camera, const mrpt::img::CImage& image) {
  camera.ncols = static_cast<std::uint32_t>(image.getWidth());
  camera.nrows = static_cast<std::uint32_t>(image.getHeight());
  const std::vector<double>& k = given.intrinsics;
  camera.setIntrinsicParamsFromValues(k[0], k[1], k[2], k[3]);
  std::vector<double> d = given.dist;
  d.resize(5, 0);
  if (distortion == "radtan") camera.setDistortionPlumbBob(d[0], d[1], d[2], d[3], d[4]);
  if (distortion == "equidistant") camera.setDistortionKannalaBrandt(d[0], d[1], d[2], d[3]);
  return camera;
}

}  // namespace

const std::vector<std::string>& acquisitionKeys() {
  static const std::vector<std::string> keys{
      "optional",    "clock",        "stamp_offset_s",   "intrinsics", "distortion",       "dist",
      "camera_pose", "side_by_side", "right_intrinsics", "right_dist", "right_camera_pose"};
  return keys;
}

SensorSection readSensorSection(const Settings& settings, const std::string& section) {
  SensorSection s;
  s.name = section;
  SettingsReader reader(settings);
  declare(reader, s);
  if (settings.find(section, "process_rate") == nullptr) {
    throw SettingsError({settings.name(), 0}, section, "process_rate",
                        "missing; calls of the driver per second");
  }
  requireSize(settings, s, "intrinsics", s.intrinsics, 4, 4);
  requireSize(settings, s, "dist", s.dist, 4, 5);
  requireSize(settings, s, "camera_pose", s.camera_pose, 6, 6);
  requireSize(settings, s, "right_intrinsics", s.right_intrinsics, 4, 4);
  requireFocalLengths(settings, s, "intrinsics", s.intrinsics);
  requireFocalLengths(settings, s, "right_intrinsics", s.right_intrinsics);
  requireSize(settings, s, "right_dist", s.right_dist, 4, 5);
  requireSize(settings, s, "right_camera_pose", s.right_camera_pose, 6, 6);
  return s;
}

void complete(const SensorSection& s, mrpt::obs::CObservation* observation, bool right) {
  if (s.stamp_offset_s != 0) {
    observation->timestamp = rawlog::toMrptTime(rawlog::fromMrptTime(observation->timestamp) +
                                                fromSeconds(s.stamp_offset_s));
  }
  auto* image = dynamic_cast<mrpt::obs::CObservationImage*>(observation);
  if (image == nullptr) return;
  const GivenCamera given = cameraOf(s, right);
  if (!given.intrinsics.empty()) {
    image->cameraParams = withIntrinsics(s.distortion, given, image->cameraParams, image->image);
  }
  if (given.pose.empty()) return;
  const std::vector<double>& p = given.pose;
  image->cameraPose = mrpt::poses::CPose3D(p[0], p[1], p[2], p[3] * kRadPerDeg, p[4] * kRadPerDeg,
                                           p[5] * kRadPerDeg);
}

std::vector<std::pair<mrpt::obs::CObservation::Ptr, bool>> takenApart(
    const SensorSection& section, const mrpt::obs::CObservation::Ptr& observation) {
  std::vector<mrpt::obs::CObservationImage::Ptr> images;
  const rawlog::PairLabels labels = rawlog::PairNames().of(observation->sensorLabel);
  if (const auto pair =
          std::dynamic_pointer_cast<mrpt::obs::CObservationStereoImages>(observation)) {
    images = rawlog::imagesOf(*pair, labels);
  } else if (const auto wide = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(observation);
             wide && section.side_by_side) {
    images = rawlog::halvesOf(*wide, labels);
  }
  if (images.empty()) return {{observation, false}};
  std::vector<std::pair<mrpt::obs::CObservation::Ptr, bool>> out;
  for (const auto& image : images) out.emplace_back(image, image->sensorLabel == labels.right);
  return out;
}

}  // namespace vir::roles
