#include "live/foxglove_json.h"

namespace vir::app {
namespace {

Json timeJson(TimeNs t) {
  constexpr TimeNs kSecond = 1'000'000'000;
  return {{"sec", t / kSecond}, {"nsec", t % kSecond}};
}

}  // namespace

std::string schemaOf(const std::string& title, const Json& example) {
  const auto kindOf = [](const Json& v) {
    return v.is_number_integer() ? "integer" : v.is_number() ? "number" : "string";
  };
  Json properties = Json::object();
  for (const auto& [key, value] : example.items()) {
    if (value.is_object()) {
      properties[key] = {
          {"type", "object"},
          {"title", "time"},
          {"properties", {{"sec", {{"type", "integer"}}}, {"nsec", {{"type", "integer"}}}}}};
    } else if (value.is_array()) {
      properties[key] = {{"type", "array"}};
    } else {
      properties[key] = {{"type", kindOf(value)}};
    }
  }
  return Json({{"title", title}, {"type", "object"}, {"properties", properties}}).dump();
}

Json healthJson(const StateEstimate& e) {
  const Eigen::Matrix<double, 6, 1> sigma = e.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const State& s = e.state;
  Json out;
  out["timestamp"] = timeJson(s.t);
  out["health"] = healthText(e);
  out["tracks"] = e.tracks;
  out["landmarks"] = e.landmarks;
  out["segment"] = e.segment;
  out["reprojection_rms_sigma"] = e.reprojection_rms;
  out["inertial_rms_sigma"] = e.inertial_rms;
  out["sigma_x_m"] = sigma[0];
  out["sigma_y_m"] = sigma[1];
  out["sigma_z_m"] = sigma[2];
  out["sigma_yaw_rad"] = sigma[5];
  out["speed_mps"] = s.v.norm();
  for (int i = 0; i < 3; ++i) {
    const std::string axis(1, "xyz"[i]);
    out["gyro_bias_" + axis + "_radps"] = s.bg[i];
    out["acc_bias_" + axis + "_mps2"] = s.ba[i];
  }
  out["time_offset_s"] = e.calibration.time_offset_s;
  out["cpu_ms"] = e.ms.total;
  return out;
}

Json rangeJson(const RangeRecord& r) {
  Json out;
  out["timestamp"] = timeJson(r.t);
  out["anchor"] = std::to_string(r.anchor);
  out["measured_m"] = r.measured_m;
  out["predicted_m"] = r.predicted_m;
  out["residual_m"] = r.residual_m;
  out["sigma_m"] = r.sigma_m;
  out["weight"] = r.weight;
  out["decision"] = name(r.decision);
  return out;
}

Json logJson(TimeNs t, LogLevel level, const std::string& line) {
  constexpr int kOf[] = {1, 2, 3, 4};  // debug, info, warning, error
  Json out;
  out["timestamp"] = timeJson(t);
  out["level"] = kOf[static_cast<int>(level)];
  out["message"] = line;
  out["name"] = "vir-slam";
  out["file"] = "";
  out["line"] = 0;
  return out;
}

Json annotationsJson(TimeNs t, const std::vector<Eigen::Vector2f>& pixels) {
  const Json green = {{"r", 0.0}, {"g", 0.86}, {"b", 0.35}, {"a", 1.0}};
  Json points = Json::array();
  for (const Eigen::Vector2f& px : pixels) points.push_back({{"x", px.x()}, {"y", px.y()}});
  Json group;
  group["timestamp"] = timeJson(t);
  group["type"] = 1;  // single points
  group["points"] = points;
  group["outline_color"] = green;
  group["outline_colors"] = Json::array();
  group["fill_color"] = green;
  group["thickness"] = 4.0;
  Json out;
  out["circles"] = Json::array();
  out["points"] = Json::array({group});
  out["texts"] = Json::array();
  return out;
}

}  // namespace vir::app
