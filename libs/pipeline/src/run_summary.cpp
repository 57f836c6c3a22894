#include <cmath>
#include <nlohmann/json.hpp>

#include "vir/pipeline/run_recorder.h"

namespace vir {
namespace {

using Json = nlohmann::ordered_json;

/// Three digits behind the point are more than a clock is worth.
double rounded(double v) { return std::round(v * 1e3) / 1e3; }

void put(Json* json, const char* key, const std::optional<double>& v) {
  if (v && std::isfinite(*v)) (*json)[key] = *v;
}

}  // namespace

std::string toJson(const RunSummary& s) {
  Json json;
  json["estimator"] = s.estimator;
  json["rawlog"] = s.rawlog;
  json["frames"] = s.frames;
  json["poses"] = s.poses;
  json["init_time_s"] = s.init_time_s ? Json(*s.init_time_s) : Json(nullptr);
  json["duration_s"] = s.duration_s;
  json["path_m"] = s.path_m;
  json["wall_s"] = rounded(s.wall_s);
  json["cpu_s"] = rounded(s.cpu_s);
  json["cpu_ms_per_frame"] = rounded(s.cpu_ms_per_frame);
  json["peak_rss_mb"] = rounded(s.peak_rss_mb);
  put(&json, "ate_posyaw_m", s.ate_posyaw_m);
  put(&json, "ate_posyaw_deg", s.ate_posyaw_deg);
  put(&json, "ate_smoothed_posyaw_m", s.ate_smoothed_posyaw_m);
  json["anchors"] = Json::array();
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

}  // namespace vir
