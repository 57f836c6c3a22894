#include <ceres/ceres.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "graph_state.h"
#include "vir/factors/level_edge_factor.h"

namespace vir::mission {
namespace {

using factors::LevelEdgeFactor;

/// Rounds in which the robust cost goes from convex to its true shape, by this factor each (Yang et
/// al. 2020: graduated non-convexity, truncated least squares).
constexpr int kRounds = 12;
constexpr double kSharper = 2;
constexpr int kIterationsPerRound = 3;
/// Loops whose residual is above (four degrees of freedom), and so many of them, are asked whether
/// the rest contradicts them: above this times the gate they go, so many in one solution.
constexpr double kSuspect = 1;
constexpr std::size_t kSuspects = 8;
constexpr double kTakenBack = 1.5;
constexpr int kTakenBackAtOnce = 5;
/// A loop decides alone where the rest is so much less certain than it.
constexpr double kDecidesAlone = 1e-3;
/// Keyframes beyond those of the last factorisation: so many are reached by the way alone.
constexpr std::size_t kUncovered = 40;
/// A first keyframe whose covariance nobody told.
constexpr double kFirstSigma = 1e-3;

ceres::CostFunction* edge(const Vec3& motion, double turn, const Eigen::Vector4d& variance) {
  return new LevelEdgeFactor(motion, turn,
                             variance.cwiseSqrt().cwiseInverse().asDiagonal().toDenseMatrix());
}

/// Information of ties: none where there is no variance.
ceres::CostFunction* tie(const Vec3& p_W, const Eigen::Vector4d& variance) {
  const Eigen::Vector4d weight =
      variance.unaryExpr([](double v) { return v > 0 ? 1 / std::sqrt(v) : 0.0; });
  return new LevelEdgeFactor(p_W, 0, weight.asDiagonal().toDenseMatrix());
}

double weightAt(double squared, double gate, double mu) {
  if (squared <= mu / (mu + 1) * gate) return 1;
  if (squared >= (mu + 1) / mu * gate) return 0;
  return std::sqrt(gate * mu * (mu + 1) / squared) - mu;
}

}  // namespace

std::vector<double*> MissionGraph::Impl::build(ceres::Problem* problem, double of_path) {
  std::vector<double*> moving;
  const bool map = nodes.front().fixed;
  problem->AddParameterBlock(world, 4);
  // Without a map M is W; with one nobody knows where W is in it before loops say so.
  if (map) {
    moving.push_back(world);
  } else {
    problem->SetParameterBlockConstant(world);
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    GraphNode& n = nodes[i];
    if (n.fixed) continue;
    problem->AddParameterBlock(n.x, 4);
    moving.push_back(n.x);
    const bool first = i == 0 || nodes[i - 1].fixed;
    if (first) {
      Eigen::Vector4d variance = levelCovariance(n.path.covariance, n.path.T_W_B.R()).diagonal();
      variance = variance.cwiseMax(kFirstSigma * kFirstSigma);
      problem->AddResidualBlock(tie(n.path.T_W_B.p, variance), nullptr, world, n.x);
      if (i == 0) continue;
      // From where it was, a turn of more than a radian is no step that Gauss-Newton finds.
      const LevelTransform T_M_W = n.correction();
      std::copy_n(T_M_W.t_m.data(), 3, world);
      world[3] = T_M_W.yaw_rad;
      // Holds what no loop has tied to the map yet; too weak to matter afterwards.
      constexpr double kAnywhere = 1e4, kAnyTurn = 100;
      Eigen::Vector4d anywhere;
      anywhere << Vec3::Constant(kAnywhere * kAnywhere), kAnyTurn * kAnyTurn;
      problem->AddResidualBlock(edge(n.position() - nodes[i - 1].position(), n.x[3], anywhere),
                                nullptr, nodes[i - 1].x, n.x);
      problem->SetParameterBlockConstant(nodes[i - 1].x);
      continue;
    }
    GraphNode& before = nodes[i - 1];
    // Of a gap nobody knows more than is said of it.
    const double by = n.stretch == before.stretch ? of_path : 1;
    const LevelTransform step = stepOf(i);
    problem->AddResidualBlock(edge(step.t_m, step.yaw_rad, by * n.step.way), nullptr, before.x,
                              n.x);
    if (n.step.tie.maxCoeff() > 0) {
      problem->AddResidualBlock(tie(n.path.T_W_B.p, by * n.step.tie), nullptr, world, n.x);
    }
  }
  for (std::size_t k = 0; k < loops.size(); ++k) {
    if (weights[k] <= 0) continue;
    const LevelLoop l = level(loops[k].loop);
    GraphNode& older = nodes[static_cast<std::size_t>(find(loops[k].loop.older))];
    GraphNode& newer = nodes[static_cast<std::size_t>(find(loops[k].loop.newer))];
    auto* pull = new LevelEdgeFactor(l.motion_W, l.turn_rad, sqrtInformation(l.covariance));
    problem->AddResidualBlock(
        pull, new ceres::ScaledLoss(nullptr, weights[k], ceres::TAKE_OWNERSHIP), older.x, newer.x);
    if (older.fixed) problem->SetParameterBlockConstant(older.x);
  }
  return moving;
}

double MissionGraph::Impl::minimise(int iterations) {
  ceres::Problem problem;
  build(&problem, scale);
  ceres::Solver::Options o;
  o.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  o.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;  // the same on every machine
  o.max_num_iterations = iterations;
  o.num_threads = 1;
  o.logging_type = ceres::SILENT;
  o.initial_trust_region_radius = 1e16;  // Gauss-Newton until it fails
  ceres::Solver::Summary summary;
  const std::vector<GraphNode> before = nodes;
  ceres::Solve(o, &problem, &summary);
  const bool finite = std::all_of(nodes.begin(), nodes.end(), [](const GraphNode& n) {
    return Eigen::Map<const Eigen::Vector4d>(n.x).allFinite();
  });
  if (finite && summary.IsSolutionUsable()) return 2 * summary.final_cost;
  for (std::size_t i = 0; i < nodes.size(); ++i) std::copy_n(before[i].x, 4, nodes[i].x);
  return -1;
}

double MissionGraph::Impl::residualOf(const JudgedLoop& judged) const {
  const LevelLoop l = level(judged.loop);
  const LevelEdgeFactor f(l.motion_W, l.turn_rad, sqrtInformation(l.covariance));
  const double* x[2] = {nodes[static_cast<std::size_t>(find(judged.loop.older))].x,
                        nodes[static_cast<std::size_t>(find(judged.loop.newer))].x};
  Eigen::Vector4d r;
  f.Evaluate(x, r.data(), nullptr);
  return r.squaredNorm();
}

double MissionGraph::Impl::contradiction(const JudgedLoop& judged) {
  auto solved = relative(find(judged.loop.older), find(judged.loop.newer));
  if (!solved) return 0;
  LevelGuess said = guess(judged.loop);
  said.P -= solved->P;
  // A loop that nothing else confirms decides alone: no difference, and none to divide by.
  const Eigen::Matrix4d floor = kDecidesAlone * guess(judged.loop).P;
  if ((said.P - floor).ldlt().vectorD().minCoeff() <= 0) return 0;
  solved->P.setZero();
  return chiSquare(*solved, said);
}

bool MissionGraph::Impl::takeIn() {
  bool any = false;
  for (std::size_t k = 0; k < loops.size(); ++k) {
    if (loops[k].state != LoopState::taken_back) continue;
    const int older = find(loops[k].loop.older), newer = find(loops[k].loop.newer);
    if (!tied(older, newer)) continue;
    const auto known = relative(older, newer);
    if (!known || chiSquare(*known, guess(loops[k].loop)) > 0.5 * options.gate) continue;
    loops[k].state = LoopState::accepted;
    weights[k] = 1;
    any = true;
  }
  return any;
}

void MissionGraph::Impl::graduate(double worst) {
  double mu = options.gate / (2 * worst - options.gate);
  for (int round = 0; round < kRounds; ++round) {
    bool decided = true;
    for (std::size_t k = 0; k < loops.size(); ++k) {
      if (loops[k].state != LoopState::accepted) continue;
      weights[k] = weightAt(residualOf(loops[k]), options.gate, mu);
      decided = decided && (weights[k] == 0 || weights[k] == 1);
    }
    minimise(kIterationsPerRound);
    if (decided && round > 0) break;
    mu *= kSharper;
  }
  for (std::size_t k = 0; k < loops.size(); ++k) {
    if (loops[k].state != LoopState::accepted) continue;
    weights[k] = weights[k] < 0.5 ? 0 : 1;
    if (weights[k] == 0) loops[k].state = LoopState::taken_back;
  }
  minimise(options.iterations);
}

bool MissionGraph::Impl::takeBackWorst() {
  std::vector<std::pair<double, std::size_t>> suspects;
  for (std::size_t k = 0; k < loops.size(); ++k) {
    if (loops[k].state != LoopState::accepted) continue;
    const double squared = residualOf(loops[k]);
    if (squared > kSuspect) suspects.emplace_back(squared, k);
  }
  const std::size_t few = std::min(kSuspects, suspects.size());
  std::partial_sort(suspects.begin(), suspects.begin() + static_cast<std::ptrdiff_t>(few),
                    suspects.end(), std::greater<>());
  suspects.resize(few);
  double most = kTakenBack * options.gate;
  std::size_t worst = loops.size();
  for (const auto& [squared, k] : suspects) {
    const double against = contradiction(loops[k]);
    if (against <= most) continue;
    most = against;
    worst = k;
  }
  if (worst == loops.size()) return false;
  loops[worst].state = LoopState::taken_back;
  weights[worst] = 0;
  factor.reset();
  return true;
}

void MissionGraph::Impl::decideOnLoops() {
  factor.reset();
  if (takeIn()) minimise(options.iterations);
  double worst = 0;
  for (const JudgedLoop& l : loops) {
    if (l.state == LoopState::accepted) worst = std::max(worst, residualOf(l));
  }
  if (worst > options.gate) graduate(worst);
  factor.reset();
  for (int i = 0; i < kTakenBackAtOnce && takeBackWorst(); ++i) {
    minimise(options.iterations);
    factor.reset();
  }
}

std::unique_ptr<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>> MissionGraph::Impl::factorOf(
    double of_path) {
  ceres::Problem problem;
  ceres::Problem::EvaluateOptions o;
  o.parameter_blocks = build(&problem, of_path);
  ceres::CRSMatrix crs;
  if (o.parameter_blocks.empty() || !problem.Evaluate(o, nullptr, nullptr, nullptr, &crs)) {
    return nullptr;
  }
  const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> J(
      crs.num_rows, crs.num_cols, static_cast<int>(crs.values.size()), crs.rows.data(),
      crs.cols.data(), crs.values.data());
  const Eigen::SparseMatrix<double> by_column = J;
  const Eigen::SparseMatrix<double> H = by_column.transpose() * by_column;
  auto out = std::make_unique<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>(H);
  if (out->info() != Eigen::Success) out.reset();
  return out;
}

const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>* MissionGraph::Impl::factorised() {
  if (factor && nodes.size() - covered <= kUncovered) return factor.get();
  covered = nodes.size();
  factor = factorOf(1);
  column.assign(nodes.size(), -1);
  int next = nodes.front().fixed ? 4 : 0;  // behind `world`
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].fixed) continue;
    column[i] = next;
    next += 4;
  }
  return factor.get();
}

LevelGuess MissionGraph::Impl::along(std::size_t from, std::size_t to) const {
  LevelGuess out;
  for (std::size_t k = from + 1; k <= to; ++k) {
    LevelGuess step;
    step.T = nodes[k - 1].level().inverse() * nodes[k].level();
    step.P = nodes[k].step.way.asDiagonal();
    out = out * step;
  }
  return out;
}

std::optional<LevelGuess> MissionGraph::Impl::relative(int older, int newer) {
  const auto a = static_cast<std::size_t>(older), b = static_cast<std::size_t>(newer);
  LevelGuess out;
  out.T = nodes[a].level().inverse() * nodes[b].level();
  if (a == b || (nodes[a].fixed && nodes[b].fixed)) return out;
  if (b < a) {
    const auto turned = relative(newer, older);
    return turned ? std::optional<LevelGuess>(inverse(*turned)) : std::nullopt;
  }
  const auto* H = factorised();
  if (H == nullptr) return std::nullopt;
  if (a >= covered) return along(a, b);
  const std::size_t to = std::min(b, covered - 1);
  const LevelEdgeFactor f(Vec3::Zero(), 0, Eigen::Matrix4d::Identity());
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> J[2];
  double* jacobians[2] = {J[0].data(), J[1].data()};
  const double* x[2] = {nodes[a].x, nodes[to].x};
  Eigen::Vector4d r;
  f.Evaluate(x, r.data(), jacobians);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(H->rows(), 4);
  for (int k = 0; k < 2; ++k) {
    const int at = column[k == 0 ? a : to];
    if (at >= 0) right.middleRows(at, 4) += J[k].transpose();
  }
  LevelGuess solved;
  solved.T = nodes[a].level().inverse() * nodes[to].level();
  // J H^-1 J^T by the lower half alone: few rows of it are not zero before the oldest of the two.
  Eigen::MatrixXd half = H->permutationP() * right;
  H->matrixL().solveInPlace(half);
  solved.P = half.transpose() * H->vectorD().cwiseInverse().asDiagonal() * half;
  out = to < b ? solved * along(to, b) : solved;
  if (!out.P.allFinite()) return std::nullopt;
  return out;
}

}  // namespace vir::mission
