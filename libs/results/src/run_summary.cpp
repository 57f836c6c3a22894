#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "vir/formats/lens_names.h"
#include "vir/results/run_recorder.h"

namespace vir::results {
namespace {

using Json = nlohmann::ordered_json;

/// Three digits behind the point are more than a clock is worth.
double rounded(double v) { return std::round(v * 1e3) / 1e3; }

void put(Json* json, const char* key, const std::optional<double>& v) {
  if (v && std::isfinite(*v)) (*json)[key] = *v;
}

Json toJson(const Vec3& v) { return v.allFinite() ? Json({v.x(), v.y(), v.z()}) : Json(nullptr); }

/// Lengths in m.
Json toJson(const AnchorResult& anchor) {
  const Anchor& a = anchor.estimate;
  Json json;
  json["id"] = a.id;
  if (!anchor.called.empty()) json["name"] = anchor.called;
  json["state"] = name(a.state);
  json["p"] = a.has_position ? toJson(a.p_W) : Json(nullptr);
  const Vec3 sigma = a.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  json["sigma"] = a.has_position ? toJson(sigma) : Json(nullptr);
  if (a.state == AnchorState::mirror_open) json["mirror_p"] = toJson(a.mirror_p_W);
  put(&json, "bias", a.bias_m);
  put(&json, "bias_sigma", a.bias_sigma_m);
  json["ranges_used"] = a.ranges_used;
  json["ranges_rejected"] = a.ranges_rejected;
  if (!a.advice.empty()) json["advice"] = a.advice;
  if (a.waypoint_W) json["waypoint"] = toJson(*a.waypoint_W);
  put(&json, "error", anchor.error_m);
  put(&json, "error_horizontal", anchor.error_horizontal_m);
  return json;
}

/// What every camera has; on the IMU, lengths in m.
Json cameraJson(const CameraCalibration& camera, const Pose& T_B_C, double time_offset_s,
                double readout_s) {
  Json json;
  put(&json, "time_offset_s", time_offset_s);
  put(&json, "fx", camera.fx);
  put(&json, "fy", camera.fy);
  put(&json, "cx", camera.cx);
  put(&json, "cy", camera.cy);
  put(&json, "readout_s", readout_s);
  json["distortion_coeffs"] = formats::listedLens(camera).coefficients;
  const Mat3 R = T_B_C.R();
  const Vec3& p = T_B_C.p;
  if (!R.allFinite() || !p.allFinite()) return json;
  json["T_B_C"] = {R(0, 0), R(0, 1), R(0, 2), p.x(), R(1, 0), R(1, 1), R(1, 2), p.y(),
                   R(2, 0), R(2, 1), R(2, 2), p.z(), 0.0,     0.0,     0.0,     1.0};
  return json;
}

Json toJson(const Calibration& c) {
  Json json = cameraJson(c.camera, c.T_B_C, c.time_offset_s, c.readout_s);
  const auto triple = [](const Vec3& v) { return Json{v.x(), v.y(), v.z()}; };
  json["gyro_gain"] = triple(c.gyro_gain);
  json["gyro_axes_rad"] = triple(c.gyro_axes_rad);
  json["acc_gain"] = triple(c.acc_gain);
  return json;
}

/// Angles in rad, lengths in m; transforms.json says more.
Json toJson(const team::PeerResult& peer) {
  const team::TransformAnswer& a = peer.transform.answer;
  Json json;
  json["id"] = peer.id;
  json["status"] = name(a.status);
  if (!a.reason.empty()) json["reason"] = a.reason;
  const bool solved = !a.solutions.empty();
  json["yaw"] = solved ? Json(a.solutions[0].T_A_B.yaw_rad) : Json(nullptr);
  json["t"] = solved ? toJson(a.solutions[0].T_A_B.t_m) : Json(nullptr);
  put(&json, "first_unique_s", peer.transform.first_unique_s);
  json["ranges"] = peer.ranges;
  json["ranges_without_broadcast"] = peer.without_broadcast;
  json["ranges_without_pose"] = peer.without_pose;
  return json;
}

/// Angles in rad, lengths in m.
Json toJson(const SurveyFit& survey) {
  Json json;
  json["status"] = name(survey.status);
  if (!survey.reason.empty()) json["reason"] = survey.reason;
  if (survey.status == SurveyStatus::found) {
    json["yaw_rad"] = survey.T_S_W.yaw_rad;
    json["t_m"] = toJson(survey.T_S_W.t_m);
    json["covariance"] = Json::array();
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) json["covariance"].push_back(survey.covariance(r, c));
    }
  }
  json["open"] = survey.open;
  json["anchors"] = Json::array();
  for (const SurveyedResult& a : survey.anchors) {
    Json one;
    one["id"] = a.given.id;
    one["heard"] = a.heard;
    one["used"] = a.used;
    one["p"] = a.p_S ? toJson(*a.p_S) : Json(nullptr);
    if (a.p_S) put(&one, "off", (*a.p_S - a.given.p_S).norm());
    json["anchors"].push_back(one);
  }
  json["findings"] = survey.findings;
  return json;
}

void putCameraSigma(const CalibrationSigma& sigma, const CameraCalibration& camera, Json* c) {
  put(c, "time_offset_sigma_s", sigma.time_offset_s);
  put(c, "fx_sigma", sigma.focal * camera.fx);
  put(c, "fy_sigma", sigma.focal * camera.fy);
  put(c, "cx_sigma", sigma.centre_px);
  put(c, "cy_sigma", sigma.centre_px);
  put(c, "distortion_sigma", sigma.distortion);
  put(c, "T_B_C_position_sigma_m", sigma.position_m);
  put(c, "T_B_C_rotation_sigma_rad", sigma.rotation_rad);
}

}  // namespace

void takeReport(const roles::EstimatorReport& report, RunSummary* s) {
  s->resets = report.resets;
  s->doubts = report.doubts;
  s->calibration = report.calibration;
  s->further_labels = report.further_labels;
  s->calibration_sigma = report.calibration_sigma;
  s->further_sigma = report.further_sigma;
  s->calibration_covariance = report.calibration_covariance;
  s->calibration_given = report.calibration_given;
  s->calibration_assumed = report.calibration_assumed;
  s->longest_wait_reason = report.longest_wait_reason;
  s->counters.insert(s->counters.end(), report.counters.begin(), report.counters.end());
  s->warnings.insert(s->warnings.end(), report.warnings.begin(), report.warnings.end());
}

std::string toJson(const RunSummary& s) {
  Json json;
  json["estimator"] = s.estimator;
  json["rawlog"] = s.rawlog;
  json["frames"] = s.frames;
  json["poses"] = s.poses;
  json["init_time_s"] = s.init_time_s ? Json(*s.init_time_s) : Json(nullptr);
  put(&json, "in_map_s", s.in_map_s);
  json["duration_s"] = s.duration_s;
  json["path_m"] = s.path_m;
  json["wall_s"] = rounded(s.wall_s);
  json["cpu_s"] = rounded(s.cpu_s);
  json["cpu_ms_per_frame"] = rounded(s.cpu_ms_per_frame);
  json["peak_rss_mb"] = rounded(s.peak_rss_mb);
  put(&json, "ate_posyaw_m", s.ate_posyaw_m);
  put(&json, "ate_posyaw_deg", s.ate_posyaw_deg);
  put(&json, "ate_smoothed_posyaw_m", s.ate_smoothed_posyaw_m);
  put(&json, "rpe_1s_m", s.rpe_1s_m);
  put(&json, "rpe_1s_deg", s.rpe_1s_deg);
  put(&json, "rpe_10m_m", s.rpe_10m_m);
  put(&json, "rpe_10m_deg", s.rpe_10m_deg);
  put(&json, "nees_position", s.nees_position);
  json["anchors"] = Json::array();
  for (const AnchorResult& a : s.anchors) json["anchors"].push_back(toJson(a));
  json["ranges"] = {{"accepted", s.ranges_accepted},
                    {"collected", s.ranges_collected},
                    {"rejected", s.ranges_rejected},
                    {"before_start", s.ranges_before_start}};
  if (s.loops) json["loops"] = {{"accepted", s.loops->first}, {"rejected", s.loops->second}};
  if (s.survey) json["survey"] = toJson(*s.survey);
  if (!s.peers.empty()) json["peers"] = Json::array();
  for (const team::PeerResult& p : s.peers) json["peers"].push_back(toJson(p));
  if (s.calibration) json["calibration"] = toJson(*s.calibration);
  if (s.calibration && s.calibration_sigma) {
    const CalibrationSigma& sigma = *s.calibration_sigma;
    Json& c = json["calibration"];
    putCameraSigma(sigma, s.calibration->camera, &c);
    put(&c, "gyro_gain_sigma", sigma.gyro_gain);
    put(&c, "gyro_axes_sigma_rad", sigma.gyro_axes_rad);
    put(&c, "acc_gain_sigma", sigma.acc_gain);
  }
  if (s.calibration) {
    const std::vector<CameraMount>& further = s.calibration->further;
    for (std::size_t k = 0; k < std::min(further.size(), s.further_labels.size()); ++k) {
      const CameraMount& m = further[k];
      Json& c = json["calibration"]["further"][s.further_labels[k]];
      c = cameraJson(m.camera, m.T_B_C, m.time_offset_s, m.readout_s);
      if (k < s.further_sigma.size()) putCameraSigma(s.further_sigma[k], m.camera, &c);
    }
  }
  json["verdict"] = name(s.verdict);
  json["doubts"] = s.doubts;
  json["resets"] = s.resets;
  json["longest_wait_reason"] = s.longest_wait_reason;
  json["interrupted"] = s.interrupted;
  if (!s.error.empty()) json["error"] = s.error;
  json["counters"] = Json::object();
  for (const auto& [name, count] : s.counters) json["counters"][name] = count;
  json["warnings"] = s.warnings;
  // A label or path of a recording may hold bytes that are no UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace vir::results
