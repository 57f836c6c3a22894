#include "vir/team/transform_graph.h"

#include <Eigen/Cholesky>
#include <limits>
#include <optional>
#include <set>

#include "evidence_cost.h"

namespace vir::team {
namespace {

constexpr double kLoopChi2 = 23.5;  // 1 - 1e-4 of four degrees of freedom

/// x = (yaw, t) of T_A_C = T_A_B T_B_C: d x / d (T_A_B), d x / d (T_B_C).
void productJacobians(const WorldTransform& T_A_B, const WorldTransform& T_B_C, Mat4* J_first,
                      Mat4* J_second) {
  *J_first = Mat4::Identity();
  J_first->block<3, 1>(1, 0) = Vec3::UnitZ().cross(rotZ(T_A_B.yaw_rad) * T_B_C.t_m);
  *J_second = Mat4::Identity();
  J_second->bottomRightCorner<3, 3>() = rotZ(T_A_B.yaw_rad);
}

TransformEdge inverseOf(const TransformEdge& e) {
  TransformEdge out{e.to, e.from, e.T_to_from.inverse(), e.covariance};
  // t' = -R^T t, yaw' = -yaw.
  const Mat3 Rt = rotZ(-e.T_to_from.yaw_rad);
  Mat4 J = Mat4::Zero();
  J(0, 0) = -1;
  J.bottomRightCorner<3, 3>() = -Rt;
  J.block<3, 1>(1, 0) = Vec3::UnitZ().cross(Rt * e.T_to_from.t_m);
  out.covariance = J * e.covariance * J.transpose();
  return out;
}

std::optional<TransformEdge> edgeBetween(const std::vector<TransformEdge>& edges,
                                         const std::string& from, const std::string& to) {
  for (const TransformEdge& e : edges) {
    if (e.from == from && e.to == to) return e;
    if (e.from == to && e.to == from) return inverseOf(e);
  }
  return std::nullopt;
}

std::set<std::string> robotsOf(const std::vector<TransformEdge>& edges) {
  std::set<std::string> robots;
  for (const TransformEdge& e : edges) {
    robots.insert(e.from);
    robots.insert(e.to);
  }
  return robots;
}

}  // namespace

Eigen::Matrix4d composedCovariance(const WorldTransform& T_A_B, const Eigen::Matrix4d& cov_A_B,
                                   const WorldTransform& T_B_C, const Eigen::Matrix4d& cov_B_C) {
  Mat4 first, second;
  productJacobians(T_A_B, T_B_C, &first, &second);
  return first * cov_A_B * first.transpose() + second * cov_B_C * second.transpose();
}

std::vector<TransformLoop> checkLoops(const std::vector<TransformEdge>& edges) {
  std::vector<TransformLoop> out;
  const std::set<std::string> names = robotsOf(edges);
  const std::vector<std::string> robots(names.begin(), names.end());
  for (std::size_t i = 0; i < robots.size(); ++i) {
    for (std::size_t j = i + 1; j < robots.size(); ++j) {
      for (std::size_t k = j + 1; k < robots.size(); ++k) {
        const auto ba = edgeBetween(edges, robots[j], robots[i]);
        const auto cb = edgeBetween(edges, robots[k], robots[j]);
        const auto ac = edgeBetween(edges, robots[i], robots[k]);
        if (!ba || !cb || !ac) continue;
        // A <- B <- C <- A must be no motion at all.
        const WorldTransform T_A_C = ba->T_to_from * cb->T_to_from;
        const Mat4 C_A_C =
            composedCovariance(ba->T_to_from, ba->covariance, cb->T_to_from, cb->covariance);
        const WorldTransform round = T_A_C * ac->T_to_from;
        const Mat4 C = composedCovariance(T_A_C, C_A_C, ac->T_to_from, ac->covariance);
        TransformLoop loop;
        loop.robots = robots[i] + " " + robots[j] + " " + robots[k];
        loop.error << wrapAngle(round.yaw_rad), round.t_m;
        loop.chi2 = loop.error.dot(C.ldlt().solve(loop.error));
        loop.consistent = loop.chi2 <= kLoopChi2;
        out.push_back(loop);
      }
    }
  }
  return out;
}

std::map<std::string, WorldTransform> commonFrame(const std::string& root,
                                                  const std::vector<TransformEdge>& edges) {
  struct Route {
    WorldTransform T;
    Mat4 covariance = Mat4::Zero();
    double length() const { return covariance.bottomRightCorner<3, 3>().trace(); }
  };
  std::map<std::string, Route> open{{root, Route()}}, done;
  while (!open.empty()) {  // Dijkstra
    auto nearest = open.begin();
    for (auto it = open.begin(); it != open.end(); ++it) {
      if (it->second.length() < nearest->second.length()) nearest = it;
    }
    const std::string here = nearest->first;
    const Route route = nearest->second;
    open.erase(nearest);
    done[here] = route;
    for (const std::string& other : robotsOf(edges)) {
      if (done.count(other) > 0) continue;
      const auto edge = edgeBetween(edges, other, here);
      if (!edge) continue;
      const Route next{
          route.T * edge->T_to_from,
          composedCovariance(route.T, route.covariance, edge->T_to_from, edge->covariance)};
      const auto known = open.find(other);
      if (known == open.end() || next.length() < known->second.length()) open[other] = next;
    }
  }
  std::map<std::string, WorldTransform> out;
  for (const auto& [name, route] : done) out[name] = route.T;
  return out;
}

}  // namespace vir::team
