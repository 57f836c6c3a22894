#include "output/team_json.h"

#include <nlohmann/json.hpp>

namespace vir::app {
namespace {

using Json = nlohmann::ordered_json;

Json array(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

Json robotJson(const RobotPlace& robot) {
  const team::TeamPlace& place = robot.place;
  const Eigen::Vector4d sigma = place.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  Json json;
  json["id"] = robot.id;
  json["yaw"] = place.T_C_world.yaw_rad;
  json["t"] = array(place.T_C_world.t_m);
  json["sigma_yaw"] = sigma[0];
  json["sigma_t"] = array(sigma.tail<3>());
  json["told_t_ns"] = robot.told ? Json(robot.told->t) : Json(nullptr);
  json["p"] = robot.told ? array(robot.told->T_W_B.p) : Json(nullptr);
  const Quat q = robot.told ? robot.told->T_W_B.q : Quat::Identity();
  json["q"] = robot.told ? Json{q.x(), q.y(), q.z(), q.w()} : Json(nullptr);
  return json;
}

Json jsonOf(const TeamState& team) {
  Json json;
  json["type"] = "team";
  json["t_ns"] = team.t;
  json["id"] = team.own;
  json["frame"] = nullptr;
  if (team.frame) {
    json["frame"] = Json{{"robot", team.frame->founder.robot},
                         {"session", std::to_string(team.frame->founder.session)},
                         {"segment", team.frame->founder.segment},
                         {"founded_t_ns", team.frame->founded}};
  }
  json["robots"] = Json::array();
  for (const RobotPlace& robot : team.robots) json["robots"].push_back(robotJson(robot));
  json["left_out"] = Json::array();
  for (const auto& [a, b] : team.left_out) json["left_out"].push_back(Json{a, b});
  return json;
}

}  // namespace

std::string teamJson(const TeamState& team) { return jsonOf(team).dump(2) + "\n"; }
std::string teamLine(const TeamState& team) { return jsonOf(team).dump(); }

}  // namespace vir::app
