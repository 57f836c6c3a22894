#include "vir/results/transforms_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace vir::results {
namespace {

using Json = nlohmann::ordered_json;

Json numberOrNull(double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); }

template <typename Vector>
Json listOf(const Vector& v) {
  Json out = Json::array();
  for (int i = 0; i < v.size(); ++i) out.push_back(numberOrNull(v[i]));
  return out;
}

void addTransform(const team::WorldTransform& T, const Eigen::Matrix4d& covariance, Json* out) {
  (*out)["yaw_rad"] = T.yaw_rad;
  (*out)["t_m"] = listOf(T.t_m);
  Json rows = Json::array();
  for (int i = 0; i < 4; ++i) rows.push_back(listOf(Eigen::Vector4d(covariance.row(i))));
  (*out)["covariance"] = rows;
}

Json pairJson(const team::PairTransform& pair) {
  const team::TransformAnswer& a = pair.answer;
  Json out;
  out["from"] = pair.from;
  out["to"] = pair.to;
  if (a.solutions.empty()) {
    out["yaw_rad"] = nullptr;
    out["t_m"] = nullptr;
    out["covariance"] = nullptr;
  } else {
    addTransform(a.solutions[0].T_A_B, a.solutions[0].covariance, &out);
  }
  out["status"] = name(a.status);
  out["reason"] = a.reason;
  out["open"] = Json::array();
  if (a.height_open) out["open"].push_back("z");
  out["alternative"] = nullptr;
  if (a.status != team::TransformStatus::unique && a.solutions.size() > 1) {
    Json other;
    addTransform(a.solutions[1].T_A_B, a.solutions[1].covariance, &other);
    other["cost_above"] = numberOrNull(a.solutions[1].cost - a.solutions[0].cost);
    out["alternative"] = other;
  }
  const int rejected = a.solutions.empty() ? 0 : a.solutions[0].rejected;
  out["ranges_used"] = a.solutions.empty() ? 0 : a.solutions[0].used;
  out["ranges_rejected"] = rejected + a.ignored;
  out["anchors_used"] = a.solutions.empty() ? 0 : a.solutions[0].anchors_used;
  out["places"] = a.places;
  out["places_used"] = a.solutions.empty() ? 0 : a.solutions[0].places_used;
  out["first_unique_s"] = pair.first_unique_s ? Json(*pair.first_unique_s) : Json(nullptr);
  out["joint"] = pair.joint;
  return out;
}

}  // namespace

std::string transformsJson(const std::vector<team::PairTransform>& pairs,
                           const team::MergedMap& map) {
  Json out;
  out["common_frame"] = map.root;
  out["robots"] = Json::array();
  for (const auto& [name, T] : map.T_root) {
    Json robot{{"name", name}};
    addTransform(T, map.covariance.at(name), &robot);
    out["robots"].push_back(robot);
  }
  out["transforms"] = Json::array();
  for (const team::PairTransform& pair : pairs) out["transforms"].push_back(pairJson(pair));
  out["left_out"] = Json::array();
  for (const team::TransformEdge& e : map.left_out) {
    out["left_out"].push_back({{"from", e.from}, {"to", e.to}});
  }
  out["loops"] = Json::array();
  for (const team::TransformLoop& loop : map.loops) {
    out["loops"].push_back({{"robots", loop.robots},
                            {"yaw_error_rad", numberOrNull(loop.error[0])},
                            {"offset_error_m", listOf(Vec3(loop.error.tail<3>()))},
                            {"chi2", numberOrNull(loop.chi2)},
                            {"consistent", loop.consistent}});
  }
  return out.dump(2) + "\n";
}

}  // namespace vir::results
