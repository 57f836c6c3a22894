#include "live/pose_stream.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace vir::app {
namespace {

using Json = nlohmann::ordered_json;

Json array(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

void putState(Json* json, const State& state) {
  const Pose& T_W_B = state.T_W_B;
  (*json)["t_ns"] = state.t;
  (*json)["p"] = array(T_W_B.p);
  (*json)["q"] = {T_W_B.q.x(), T_W_B.q.y(), T_W_B.q.z(), T_W_B.q.w()};
  (*json)["v"] = array(state.v);
}

std::string text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string poseLine(const State& state) {
  Json json;
  json["type"] = "pose";
  putState(&json, state);
  return text(json);
}

std::string estimateLine(const StateEstimate& e) {
  Json json;
  json["type"] = "estimate";
  json["valid"] = e.valid;
  putState(&json, e.state);
  const Eigen::Matrix<double, 6, 1> sigma = e.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  json["sigma_p"] = array(sigma.head<3>());
  json["sigma_r"] = array(sigma.tail<3>());
  json["segment"] = e.segment;
  json["tracks"] = e.tracks;
  json["health"] = healthText(e);
  return text(json);
}

std::string anchorLine(TimeNs t, const Anchor& a) {
  Json json;
  json["type"] = "anchor";
  json["t_ns"] = t;
  json["id"] = a.id;
  json["state"] = name(a.state);
  json["p"] = a.has_position ? array(a.p_W) : Json(nullptr);
  json["sigma"] =
      a.has_position ? array(a.covariance.diagonal().cwiseMax(0).cwiseSqrt()) : Json(nullptr);
  if (!a.advice.empty()) json["advice"] = a.advice;
  if (a.waypoint_W) json["waypoint"] = array(*a.waypoint_W);
  return text(json);
}

std::string surveyLine(TimeNs t, const SurveyFit& survey) {
  Json json;
  json["type"] = "survey";
  json["t_ns"] = t;
  json["status"] = name(survey.status);
  const bool found = survey.status == SurveyStatus::found;
  json["yaw"] = found ? Json(survey.T_S_W.yaw_rad) : Json(nullptr);
  json["t"] = found ? array(survey.T_S_W.t_m) : Json(nullptr);
  const Eigen::Vector4d sigma = survey.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  json["sigma_yaw"] = found ? Json(sigma[0]) : Json(nullptr);
  json["sigma_t"] = found ? array(sigma.tail<3>()) : Json(nullptr);
  json["open"] = survey.open;
  return text(json);
}

std::string peerLine(TimeNs t, const team::PeerResult& peer) {
  Json json;
  json["type"] = "peer";
  json["t_ns"] = t;
  json["id"] = peer.id;
  const team::TransformAnswer& answer = peer.transform.answer;
  json["status"] = name(answer.status);
  json["reason"] = answer.reason;
  json["open"] = Json::array();
  if (answer.height_open) json["open"].push_back("z");
  const bool placed = answer.status == team::TransformStatus::unique;
  const team::TransformSolution s = placed ? answer.solutions[0] : team::TransformSolution();
  const Eigen::Vector4d sigma = s.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  json["yaw"] = placed ? Json(s.T_A_B.yaw_rad) : Json(nullptr);
  json["t"] = placed ? array(s.T_A_B.t_m) : Json(nullptr);
  json["sigma_yaw"] = placed ? Json(sigma[0]) : Json(nullptr);
  json["sigma_t"] = placed ? array(sigma.tail<3>()) : Json(nullptr);
  json["told_t_ns"] = peer.told ? Json(peer.told->t) : Json(nullptr);
  const auto there = team::poseInOwnWorld(peer);
  json["p"] = there ? array(there->T_W_B.p) : Json(nullptr);
  json["sigma_p"] =
      there ? array(there->covariance.diagonal().head<3>().cwiseMax(0).cwiseSqrt()) : Json(nullptr);
  const Quat q = there ? there->T_W_B.q : Quat::Identity();
  json["q"] = there ? Json{q.x(), q.y(), q.z(), q.w()} : Json(nullptr);
  return text(json);
}

}  // namespace vir::app
