#include "vir/team/team_graph.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "evidence_cost.h"

namespace vir::team {
namespace {

/// Share of a cost below which two are alike: of one loop, each transform may be the wrong one.
constexpr double kTie = 1e-3;
constexpr int kIterations = 20;
constexpr double kSmallStep = 1e-10;  // [rad, m]
constexpr double kSmallestVariance = 1e-12;

using PairName = std::pair<std::string, std::string>;

PairName nameOf(const TransformEdge& e) { return std::minmax(e.from, e.to); }

bool usable(const TransformEdge& e) {
  if (e.from == e.to || !std::isfinite(e.T_to_from.yaw_rad) || !e.T_to_from.t_m.allFinite() ||
      !e.covariance.allFinite()) {
    return false;
  }
  const Eigen::LDLT<Mat4> ldlt(0.5 * (e.covariance + e.covariance.transpose()));
  return ldlt.info() == Eigen::Success && ldlt.vectorD().minCoeff() > kSmallestVariance;
}

double uncertainty(const TransformEdge& e) { return e.covariance.diagonal().tail<3>().sum(); }

/// (yaw, t) of what an edge should say as the worlds lie, less what it says.
Vec4 residualOf(const TransformEdge& e, const PlacedWorld& from, const PlacedWorld& to) {
  const WorldTransform T = to.T_root.inverse() * from.T_root;
  Vec4 r;
  r << wrapAngle(T.yaw_rad - e.T_to_from.yaw_rad), T.t_m - e.T_to_from.t_m;
  return r;
}

double chi2Of(const TransformEdge& e, const TeamGraph& g) {
  const Vec4 r = residualOf(e, g.worlds.at(e.from), g.worlds.at(e.to));
  return r.dot(e.covariance.ldlt().solve(r));
}

class Solver {
 public:
  explicit Solver(TeamGraph* graph) : graph_(*graph) {
    for (const auto& [name, world] : graph_.worlds) {
      if (name != graph_.root) column_.emplace(name, 4 * static_cast<long>(column_.size()));
    }
  }

  void solve() {
    const long n = 4 * static_cast<long>(column_.size());
    for (int i = 0; i < kIterations && n > 0; ++i) {
      H_ = Eigen::MatrixXd::Zero(n, n);
      g_ = Eigen::VectorXd::Zero(n);
      for (const TransformEdge& e : graph_.used) add(e);
      const Eigen::LDLT<Eigen::MatrixXd> ldlt(H_);
      const Eigen::VectorXd step = -ldlt.solve(g_);
      for (const auto& [name, at] : column_) {
        WorldTransform& T = graph_.worlds[name].T_root;
        T.yaw_rad = wrapAngle(T.yaw_rad + step[at]);
        T.t_m += step.segment<3>(at + 1);
      }
      if (!(step.cwiseAbs().maxCoeff() > kSmallStep)) break;
    }
    if (n == 0) return;
    const Eigen::MatrixXd C =
        Eigen::LDLT<Eigen::MatrixXd>(H_).solve(Eigen::MatrixXd::Identity(n, n));
    for (const auto& [name, at] : column_) graph_.worlds[name].covariance = C.block<4, 4>(at, at);
  }

 private:
  void add(const TransformEdge& e) {
    const PlacedWorld &from = graph_.worlds.at(e.from), &to = graph_.worlds.at(e.to);
    const Mat4 W = e.covariance.ldlt().solve(Mat4::Identity());
    const Vec4 r = residualOf(e, from, to);
    const Mat3 Rt = rotZ(-to.T_root.yaw_rad);
    Mat4 J_from = Mat4::Identity(), J_to = -Mat4::Identity();
    J_from.bottomRightCorner<3, 3>() = Rt;
    J_to.bottomRightCorner<3, 3>() = -Rt;
    J_to.block<3, 1>(1, 0) = -Vec3::UnitZ().cross(Rt * (from.T_root.t_m - to.T_root.t_m));
    const std::pair<std::map<std::string, long>::const_iterator, const Mat4*> ends[] = {
        {column_.find(e.from), &J_from}, {column_.find(e.to), &J_to}};
    for (const auto& [a, J_a] : ends) {
      if (a == column_.end()) continue;
      g_.segment<4>(a->second) += J_a->transpose() * W * r;
      for (const auto& [b, J_b] : ends) {
        if (b == column_.end()) continue;
        H_.block<4, 4>(a->second, b->second) += J_a->transpose() * W * *J_b;
      }
    }
  }

  TeamGraph& graph_;
  std::map<std::string, long> column_;
  Eigen::MatrixXd H_;
  Eigen::VectorXd g_;
};

TeamGraph solveOnce(const std::string& root, const std::vector<TransformEdge>& edges) {
  TeamGraph out;
  out.root = root;
  for (const auto& [name, T] : commonFrame(root, edges)) out.worlds[name].T_root = T;
  for (const TransformEdge& e : edges) {
    if (out.worlds.count(e.from) > 0) out.used.push_back(e);
  }
  Solver(&out).solve();
  for (const TransformEdge& e : out.used) out.chi2 += chi2Of(e, out);
  out.redundant = 4 * static_cast<int>(out.used.size() + 1 - out.worlds.size());
  return out;
}

/// 1 - 1e-4 of chi-square (Wilson and Hilferty).
double chi2Limit(int degrees) {
  constexpr double kNormal = 3.719;
  const double v = 2.0 / (9.0 * degrees);
  return degrees * std::pow(1 - v + kNormal * std::sqrt(v), 3);
}

bool consistent(const TeamGraph& g) { return g.redundant == 0 || g.chi2 <= chi2Limit(g.redundant); }

/// Without which one of its edges all others agree best, nobody being lost.
std::size_t worstOf(const TeamGraph& g) {
  std::size_t worst = g.used.size();
  double least = 0;
  for (std::size_t i = 0; i < g.used.size(); ++i) {
    std::vector<TransformEdge> others = g.used;
    others.erase(others.begin() + static_cast<long>(i));
    const TeamGraph without = solveOnce(g.root, others);
    if (without.worlds.size() < g.worlds.size()) continue;
    const double tie = kTie * g.chi2;
    const bool better =
        worst == g.used.size() || without.chi2 < least - tie ||
        (without.chi2 < least + tie && uncertainty(g.used[i]) > uncertainty(g.used[worst]));
    if (!better) continue;
    worst = i;
    least = without.chi2;
  }
  return worst;
}

}  // namespace

TeamGraph solveTeam(const std::string& root, std::vector<TransformEdge> edges) {
  std::stable_sort(edges.begin(), edges.end(), [](const TransformEdge& a, const TransformEdge& b) {
    return nameOf(a) < nameOf(b);
  });
  const auto same = [](const TransformEdge& a, const TransformEdge& b) {
    return nameOf(a) == nameOf(b);
  };
  edges.erase(std::unique(edges.begin(), edges.end(), same), edges.end());
  const auto bad = std::stable_partition(edges.begin(), edges.end(), usable);
  std::vector<TransformEdge> left_out(bad, edges.end());
  edges.erase(bad, edges.end());
  const std::vector<TransformLoop> loops = checkLoops(edges);
  TeamGraph out = solveOnce(root, edges);
  while (!consistent(out)) {
    const std::size_t worst = worstOf(out);
    if (worst == out.used.size()) break;
    left_out.push_back(out.used[worst]);
    std::vector<TransformEdge> rest = out.used;
    rest.erase(rest.begin() + static_cast<long>(worst));
    out = solveOnce(root, rest);
  }
  out.left_out = left_out;
  out.loops = loops;
  return out;
}

}  // namespace vir::team
