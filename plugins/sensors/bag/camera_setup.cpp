#include "camera_setup.h"

#include <Eigen/Dense>
#include <cmath>

#include "calibration_hook.h"
#include "input_error.h"

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

#ifndef VIR_HAS_CALIBRATION_FILES
struct Distorted {
  double x, y;
};
/// OpenCV's rational model with k1 k2 p1 p2 k3 k4 k5 k6.
Distorted rational(const std::vector<double>& d, double x, double y) {
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double s =
      (1 + d[0] * r2 + d[1] * r4 + d[4] * r6) / (1 + d[5] * r2 + d[6] * r4 + d[7] * r6);
  return {x * s + 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x),
          y * s + d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y};
}

/// The plumb-bob that is nearest to a rational lens over the image; returns the largest difference
/// [px]. The coefficients are linear in what they do.
double fitRadtan(const std::vector<double>& d, CameraCalibration* c) {
  constexpr int kGrid = 40;
  std::vector<Eigen::Matrix<double, 1, 5>> rows;
  std::vector<double> right;
  const double w = c->width / c->fx, h = c->height / c->fy;
  for (int i = 0; i <= kGrid; ++i) {
    for (int k = 0; k <= kGrid; ++k) {
      const double x = (1.5 * i / kGrid - 0.25) * w - c->cx / c->fx;
      const double y = (1.5 * k / kGrid - 0.25) * h - c->cy / c->fy;
      const Distorted to = rational(d, x, y);
      const double u = to.x * c->fx + c->cx, v = to.y * c->fy + c->cy;
      if (!(u >= 0 && v >= 0 && u <= c->width && v <= c->height)) continue;
      const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
      Eigen::Matrix<double, 1, 5> row;
      row << x * r2, x * r4, 2 * x * y, r2 + 2 * x * x, x * r6;
      rows.push_back(row), right.push_back(to.x - x);
      row << y * r2, y * r4, r2 + 2 * y * y, 2 * x * y, y * r6;
      rows.push_back(row), right.push_back(to.y - y);
    }
  }
  Eigen::MatrixXd A(static_cast<Eigen::Index>(rows.size()), 5);
  for (std::size_t i = 0; i < rows.size(); ++i) A.row(static_cast<Eigen::Index>(i)) = rows[i];
  const Eigen::Map<Eigen::VectorXd> b(right.data(), static_cast<Eigen::Index>(right.size()));
  if (rows.size() < 20) return 1e9;
  const Eigen::VectorXd k = A.colPivHouseholderQr().solve(b);
  for (int i = 0; i < 5; ++i) c->dist[static_cast<std::size_t>(i)] = k(i);
  c->distortion = Distortion::radtan;
  return (A * k - b).cwiseAbs().maxCoeff() * std::max(c->fx, c->fy);
}
#endif

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
#ifdef VIR_HAS_CALIBRATION_FILES  // then there is a model of ours for it
    out->distortion = Distortion::rational;
    std::copy(D.begin(), D.begin() + 8, out->dist.begin());
    return true;
#else
    const double worst = fitRadtan(D, out);
    char text[120];
    std::snprintf(text, sizeof text,
                  "the rational lens was replaced by the nearest plumb-bob: up to %.2f px off",
                  worst);
    *why = text;
    return worst < 2;
#endif
  }
  out->distortion = Distortion::radtan;
  std::copy(D.begin(), D.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(5, D.size())),
            out->dist.begin());
  return true;
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
    const double sx = static_cast<double>(width) / info.width;
    const double sy = static_cast<double>(height) / info.height;
    if (std::abs(sx - sy) > 0.01 * sx) {
      *why = "it is for " + std::to_string(info.width) + "x" + std::to_string(info.height) +
             " pixels, the images have " + std::to_string(width) + "x" + std::to_string(height);
      return false;
    }
    // Of pixel centres: the middle of the first one is 0.
    out->fx *= sx, out->fy *= sy;
    out->cx = (out->cx + 0.5) * sx - 0.5;
    out->cy = (out->cy + 0.5) * sy - 0.5;
    out->width = width, out->height = height;
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

void requireAll(const CameraSetup& c, const BagOptions& o, ProblemLog* log) {
  if (c.has_intrinsics && c.has_place) return;
  const std::string what = !c.has_intrinsics && !c.has_place ? "neither intrinsics nor its place"
                           : !c.has_intrinsics               ? "no intrinsics"
                                                             : "not its place";
  const std::string text = c.topic + ": " + what + " on the IMU " +
                           (o.calibration.empty() ? "in the recording" : "in " + o.calibration) +
                           "; give --calibration FILE with both";
  if (o.need_calibration) {
    throw InputError(text + " (or need_calibration = false to import without, for other uses)");
  }
  log->note(text);
}

}  // namespace

CalibrationExtras setUpCameras(const Survey& survey, const BagOptions& options,
                               const std::string& imu_frame, std::vector<CameraSetup>* cameras,
                               ProblemLog* log) {
  CalibrationExtras extras;
  for (CameraSetup& c : *cameras) fromRecording(survey, imu_frame, &c, log);
  if (!options.calibration.empty()) {
    extras = applyCalibrationFile(options.calibration, cameras, log);
  }
  for (const CameraSetup& c : *cameras) requireAll(c, options, log);
  return extras;
}

}  // namespace vir::bag
