#include "camera_setup.h"

#include <cmath>
#include <cstdio>

#include "calibration_hook.h"
#include "camera_scaling.h"
#include "input_error.h"
#include "vir/formats/calibration_file.h"

namespace vir::bag {
namespace {

/// `/a/b/image_raw/compressed` has its CameraInfo at `/a/b/camera_info`.
std::string infoTopicOf(const Survey& survey, std::string topic) {
  for (int i = 0; i < 3; ++i) {
    const std::size_t slash = topic.rfind('/');
    if (slash == std::string::npos) break;
    topic.resize(slash);
    if (survey.camera_infos.count(topic + "/camera_info") > 0) return topic + "/camera_info";
  }
  return {};
}

bool allZero(const std::vector<double>& v, std::size_t from) {
  for (std::size_t i = from; i < v.size(); ++i) {
    if (v[i] != 0) return false;
  }
  return true;
}

bool lensOf(const CameraInfo& info, CameraCalibration* out, std::string* why) {
  const std::vector<double>& D = info.D;
  const bool radtan = info.model == "plumb_bob" || info.model == "rational_polynomial" ||
                      info.model.empty() || info.model == "radtan" ||
                      info.model == "radial-tangential" || info.model == "Brown Conrady" ||
                      info.model == "Inverse Brown Conrady";
  out->distortion = Distortion::none;
  if (allZero(D, 0)) return true;
  if (info.model == "equidistant" || info.model == "fisheye" || info.model == "Kannala Brandt4") {
    if (D.size() < 4) {
      *why = "its equidistant lens has " + std::to_string(D.size()) + " coefficients, not 4";
      return false;
    }
    out->distortion = Distortion::equidistant;
    std::copy(D.begin(), D.begin() + 4, out->dist.begin());
    return true;
  }
  if (!radtan) {
    *why = "its distortion model '" + info.model +
           "' is not known (plumb_bob, rational_polynomial, equidistant are)";
    return false;
  }
  if (D.size() >= 8 && !allZero(D, 5)) {
    if (!allZero(D, 8)) {
      *why = "its lens has more than 8 coefficients";
      return false;
    }
    out->distortion = Distortion::rational;
    std::copy(D.begin(), D.begin() + 8, out->dist.begin());
    return true;
  }
  out->distortion = Distortion::radtan;
  std::copy(D.begin(), D.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(5, D.size())),
            out->dist.begin());
  return true;
}

/// Are images of this size those of the calibration, binned or made smaller on the way?
bool sameShape(int width, int height, const CameraCalibration& c) {
  const double sx = static_cast<double>(width) / c.width;
  return std::abs(sx - static_cast<double>(height) / c.height) <= 0.01 * sx;
}

}  // namespace

bool intrinsicsOf(const CameraInfo& info, const std::string& topic, int width, int height,
                  CameraCalibration* out, std::string* why) {
  *out = {};
  if (info.K.size() != 9 || !(info.K[0] > 0) || !(info.K[4] > 0) || info.width < 1) {
    *why = "it is empty (this camera was never calibrated)";
    return false;
  }
  const bool rectified = topic.find("rect") != std::string::npos && info.P.size() == 12 &&
                         info.P[0] > 0 && info.P[5] > 0;
  out->width = info.width;
  out->height = info.height;
  out->fx = rectified ? info.P[0] : info.K[0];
  out->fy = rectified ? info.P[5] : info.K[4];
  out->cx = rectified ? info.P[2] : info.K[2];
  out->cy = rectified ? info.P[6] : info.K[5];
  if (!rectified && !lensOf(info, out, why)) return false;
  if (width > 0 && (width != info.width || height != info.height)) {
    // Binned, or made smaller on the way.
    if (!sameShape(width, height, *out)) {
      *why = "it is for " + std::to_string(info.width) + "x" + std::to_string(info.height) +
             " pixels, the images have " + std::to_string(width) + "x" + std::to_string(height);
      return false;
    }
    scaleTo(width, height, out);
  }
  return true;
}

namespace {

void fromRecording(const Survey& survey, const std::string& imu_frame, CameraSetup* c,
                   ProblemLog* log) {
  const TopicInfo* images = survey.find(c->topic);
  const std::string info_topic = infoTopicOf(survey, c->topic);
  if (!info_topic.empty()) {
    std::string why;
    c->has_intrinsics =
        intrinsicsOf(survey.camera_infos.at(info_topic), c->topic, images ? images->width : 0,
                     images ? images->height : 0, &c->intrinsics, &why);
    if (!c->has_intrinsics) {
      log->note(info_topic + ": not used for " + c->topic + ": " + why);
    } else {
      log->note(c->topic + ": intrinsics from " + info_topic + (why.empty() ? "" : "; " + why));
    }
  }
  if (images == nullptr || survey.frames.empty()) return;
  if (const auto T = survey.frames.between(imu_frame, images->frame)) {
    c->T_B_C = *T;
    c->has_place = true;
    log->note(c->topic + ": its place on the IMU (" + imu_frame + " to " + images->frame +
              ") from /tf_static");
  }
}

/// The calibration for images of another size than its own, and for those that are made smaller.
void fitToImages(const Survey& survey, int wanted_width, CameraSetup* camera, ProblemLog* log) {
  CameraCalibration& c = camera->intrinsics;
  if (!camera->has_intrinsics) return;
  char text[160];
  const TopicInfo* images = survey.find(camera->topic);
  const bool known = images != nullptr && images->width > 0;
  if (c.width == 0) {
    try {
      formats::takeSizeOfImages(known ? images->width : 0, known ? images->height : 0, &c);
    } catch (const formats::CalibrationError& e) {
      throw InputError(camera->topic + ": " + e.what());
    }
    std::snprintf(text, sizeof text, ": the size of the images, %dx%d, taken from the first one",
                  c.width, c.height);
    log->note(camera->topic + text);
  }
  if (known && (images->width != c.width || images->height != c.height) &&
      sameShape(images->width, images->height, c)) {
    std::snprintf(text, sizeof text,
                  ": images of %dx%d, the calibration is of %dx%d: its intrinsics were scaled",
                  images->width, images->height, c.width, c.height);
    log->note(camera->topic + text);
    scaleTo(images->width, images->height, &c);
  }
  camera->recorded_width = c.width;
  camera->recorded_height = c.height;
  if (wanted_width <= 0 || wanted_width == c.width) return;
  const int height = std::max(
      1, static_cast<int>(std::lround(static_cast<double>(c.height) * wanted_width / c.width)));
  std::snprintf(text, sizeof text, ": images of %dx%d are resized to %dx%d, and the calibration",
                c.width, c.height, wanted_width, height);
  log->note(camera->topic + text);
  scaleTo(wanted_width, height, &c);
}

void requireAll(const CameraSetup& c, const BagOptions& o, ProblemLog* log) {
  if (c.has_intrinsics && c.has_place) return;
  const std::string where = o.calibration.empty() ? "in the recording" : "in " + o.calibration;
  if (c.has_intrinsics) {
    log->note(c.topic + ": not its place on the IMU " + where +
              ": a run finds it on the way; better give it (--calibration FILE)");
    return;
  }
  const std::string text =
      c.topic + ": " +
      (c.has_place ? "no intrinsics" : "neither intrinsics nor its place on the IMU") + " " +
      where + "; give --calibration FILE with both";
  if (o.need_calibration) {
    throw InputError(text + " (or need_calibration = false to import without, for other uses)");
  }
  log->note(text);
}

}  // namespace

namespace {

CalibrationExtras lookUp(const Survey& survey, const BagOptions& options,
                         const std::string& imu_frame, std::vector<CameraSetup>* cameras,
                         ProblemLog* log) {
  for (CameraSetup& c : *cameras) fromRecording(survey, imu_frame, &c, log);
  if (options.calibration.empty()) return {};
  return applyCalibrationFile(options.calibration, cameras, log);
}

}  // namespace

std::vector<std::string> lacksOf(const Survey& survey, const BagOptions& options,
                                 const std::string& imu_frame,
                                 const std::vector<std::string>& topics) {
  ProblemLog unheard;  // those that are taken say it all again
  std::vector<CameraSetup> cameras(topics.size());
  for (std::size_t i = 0; i < topics.size(); ++i) cameras[i].topic = topics[i];
  lookUp(survey, options, imu_frame, &cameras, &unheard);
  std::vector<std::string> out;
  for (CameraSetup& c : cameras) {
    std::string why;
    if (!c.has_intrinsics || !c.has_place) {
      why = "a further camera, of which " +
            std::string(c.has_place        ? "the intrinsics are"
                        : c.has_intrinsics ? "the place on the IMU is"
                                           : "neither intrinsics nor the place on the IMU are") +
            (c.has_intrinsics || c.has_place ? " not known" : " known") +
            " (CameraInfo with /tf_static, or --calibration FILE with all cameras)";
    }
    try {
      fitToImages(survey, options.width_px, &c, &unheard);
    } catch (const InputError& e) {
      why = e.what();
    }
    out.push_back(why);
  }
  return out;
}

CalibrationExtras setUpCameras(const Survey& survey, const BagOptions& options,
                               const std::string& imu_frame, std::vector<CameraSetup>* cameras,
                               ProblemLog* log) {
  const CalibrationExtras extras = lookUp(survey, options, imu_frame, cameras, log);
  for (const CameraSetup& c : *cameras) requireAll(c, options, log);
  for (CameraSetup& c : *cameras) fitToImages(survey, options.width_px, &c, log);
  return extras;
}

}  // namespace vir::bag
