#include "camera_section.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

namespace vir::formats {
namespace {

/// How many coefficients each model takes, without what belongs to the projection.
struct Counts {
  std::size_t least, most;
};

Counts countsOf(Distortion d) {
  switch (d) {
    case Distortion::radtan:
      return {4, 5};
    case Distortion::rational:
      return {8, 8};
    case Distortion::equidistant:
    case Distortion::omni:
      return {4, 4};
    case Distortion::none:
    case Distortion::double_sphere:
      break;
  }
  return {0, 0};
}

std::string nameOf(Distortion d) {
  switch (d) {
    case Distortion::radtan:
      return "radtan";
    case Distortion::rational:
      return "rational_polynomial";
    case Distortion::equidistant:
      return "equidistant";
    case Distortion::omni:
      return "omni";
    case Distortion::double_sphere:
      return "double sphere";
    case Distortion::none:
      break;
  }
  return "none";
}

/// Projection models of Kalibr, with how many numbers stand before fx.
const std::map<std::string, int>& projections() {
  static const std::map<std::string, int> known{{"pinhole", 0}, {"omni", 1}, {"ds", 2}};
  return known;
}

}  // namespace

Distortion distortionOf(const YamlSection& section, const std::string& name) {
  static const std::map<std::string, Distortion> known{
      {"radial-tangential", Distortion::radtan},
      {"radtan", Distortion::radtan},
      {"plumb_bob", Distortion::radtan},
      {"equidistant", Distortion::equidistant},
      {"equi", Distortion::equidistant},
      {"kannala_brandt", Distortion::equidistant},
      {"fisheye", Distortion::equidistant},
      {"rational_polynomial", Distortion::rational},
      {"rational", Distortion::rational},
      {"none", Distortion::none},
      {"", Distortion::none}};
  const auto it = known.find(name);
  if (it != known.end()) return it->second;
  section.fail("distortion_model is `" + name +
               "`; known are radial-tangential (radtan, plumb_bob), rational_polynomial, "
               "equidistant (kannala_brandt, fisheye) and none");
}

void setDistortion(const YamlSection& section, const std::string& key,
                   const std::vector<double>& values, CameraCalibration* camera) {
  std::vector<double> d = values;
  const Counts counts = countsOf(camera->distortion);
  // OpenCV writes its longer models with zeros at the end.
  while (d.size() > counts.most && d.back() == 0) d.pop_back();
  if (d.size() < counts.least || d.size() > counts.most) {
    section.fail("`" + section.named(key) + "` has " + std::to_string(values.size()) +
                 " numbers; " + nameOf(camera->distortion) + " takes " +
                 std::to_string(counts.least) +
                 (counts.most > counts.least ? " or " + std::to_string(counts.most) : ""));
  }
  const std::ptrdiff_t from = camera->distortion == Distortion::omni ? 1 : 0;
  std::copy(d.begin(), d.end(), camera->dist.begin() + from);
}

void setSize(const YamlSection& section, const std::string& key, double width, double height,
             CameraCalibration* camera) {
  const auto good = [](double v) { return v == std::floor(v) && v >= 8 && v <= 20000; };
  if (!good(width) || !good(height)) {
    section.fail("`" + section.named(key) +
                 "` must be width and height in pixels, each between 8 and 20000");
  }
  camera->width = static_cast<int>(width);
  camera->height = static_cast<int>(height);
}

void setSizeIfGiven(const YamlSection& section, const std::string& width, const std::string& height,
                    CameraCalibration* camera) {
  if (!section.has(width) && !section.has(height)) return;
  setSize(section, width, section.number(width), section.number(height), camera);
}

void checkIntrinsics(const YamlSection& section, const std::string& key,
                     const CameraCalibration& c) {
  if (c.fx <= 0 || c.fy <= 0) {
    section.fail("`" + section.named(key) + "`: focal lengths must be positive");
  }
  const bool known = c.width > 0;  // else takeSizeOfImages() looks
  if (c.cx < 0 || c.cy < 0 || (known && (c.cx > c.width || c.cy > c.height))) {
    section.fail("`" + section.named(key) + "`: the principal point lies outside the image");
  }
  if (c.distortion == Distortion::double_sphere && !(c.dist[1] >= 0 && c.dist[1] <= 1)) {
    section.fail("`" + section.named(key) + "`: alpha of double sphere must be between 0 and 1");
  }
  if (c.distortion == Distortion::omni && !(c.dist[0] >= 0)) {
    section.fail("`" + section.named(key) + "`: xi of omni must not be negative");
  }
}

CameraCalibration readListedCamera(const YamlSection& section) {
  CameraCalibration c;
  if (section.has("resolution")) {
    const auto size = section.numbers("resolution");
    if (size.size() != 2)
      section.fail("`" + section.named("resolution") + "` must be [width, height]");
    setSize(section, "resolution", size[0], size[1], &c);
  }
  const std::string model = section.has("camera_model") ? section.text("camera_model") : "pinhole";
  const auto projection = projections().find(model);
  if (projection == projections().end()) {
    section.fail("camera_model is `" + model + "`; known are pinhole, omni and ds (double sphere)");
  }
  const auto before = static_cast<std::size_t>(projection->second);
  const auto k = section.numbers("intrinsics");
  if (k.size() != before + 4) {
    static const char* const names[] = {"[fx, fy, cx, cy]", "[xi, fx, fy, cx, cy]",
                                        "[xi, alpha, fx, fy, cx, cy]"};
    const bool commas = k.size() == 2 * (before + 4);
    section.fail("`" + section.named("intrinsics") + "` of " + model + " must be " + names[before] +
                 "; it has " + std::to_string(k.size()) + " numbers" +
                 (commas ? ", decimal commas? write points" : "") + section.lineOf("intrinsics"));
  }
  c.fx = k[before], c.fy = k[before + 1], c.cx = k[before + 2], c.cy = k[before + 3];
  const Distortion lens = distortionOf(section, section.text("distortion_model"));
  if (before > 0 && lens != Distortion::none && !(before == 1 && lens == Distortion::radtan)) {
    section.fail("distortion_model `" + section.text("distortion_model") + "` does not go with " +
                 model);
  }
  c.distortion = lens;
  if (model == "omni") c.distortion = Distortion::omni;
  if (model == "ds") c.distortion = Distortion::double_sphere;
  if (lens != Distortion::none) {
    const std::string key = section.firstOf({"distortion_coeffs", "distortion_coefficients"});
    const std::string named = key.empty() ? "distortion_coefficients" : key;
    setDistortion(section, named, section.numbers(named), &c);
  } else if (!section.has("distortion_model") && before == 0) {
    section.fail("`" + section.named("distortion_model") + "` is missing (none, radtan, ...)");
  }
  std::copy_n(k.begin(), before, c.dist.begin());
  checkIntrinsics(section, "intrinsics", c);
  return c;
}

std::optional<double> readTimeShift(const YamlSection& section, const std::string& key,
                                    CalibrationFile* file) {
  constexpr double kMost = 10;     // [s] that [Camera] time_offset_s takes
  constexpr double kUsual = 0.25;  // [s] a camera and an IMU that one driver stamps are closer
  const std::optional<double> v = section.optionalNumber(key);
  if (!v || std::abs(*v) <= kUsual) return v;
  char text[160];
  std::snprintf(text, sizeof text, "`%s` is %g, which is read as seconds (milliseconds? then %g)",
                section.named(key).c_str(), *v, *v / 1000);
  if (!(std::abs(*v) <= kMost)) {
    section.fail(std::string(text) + "; allowed: a number of seconds from -10 to 10");
  }
  file->notes.push_back(text);
  return v;
}

void readImuNoise(const YamlSection& section, CalibrationFile* file) {
  imu::ImuNoise n;
  const std::pair<const char*, double*> fields[] = {
      {"gyroscope_noise_density", &n.gyro_noise_density},
      {"gyroscope_random_walk", &n.gyro_random_walk},
      {"accelerometer_noise_density", &n.acc_noise_density},
      {"accelerometer_random_walk", &n.acc_random_walk}};
  bool complete = true, any = false;
  for (const auto& [key, value] : fields) {
    const auto v = section.optionalNumber(key);
    any = any || v;
    *value = v.value_or(0);
    complete = complete && *value > 0;
  }
  if (complete) file->imu_noise = n;
  if (any && !complete) {
    file->notes.push_back(
        "not all four noise densities of the IMU are given and positive (gyroscope_ and "
        "accelerometer_ _noise_density and _random_walk): none is used");
  }
  file->imu_topic = section.text("rostopic");
  file->imu_rate_hz = section.optionalNumber("update_rate");
  if (!file->imu_rate_hz) file->imu_rate_hz = section.optionalNumber("rate_hz");
}

void noteMissingPoses(const std::string& how, CalibrationFile* file) {
  for (const CalibratedCamera& c : file->cameras) {
    if (c.T_B_C) continue;
    file->notes.push_back("where " + c.label + " sits on the IMU is not in the file: " + how);
  }
}

}  // namespace vir::formats
