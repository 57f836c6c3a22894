#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <cmath>

#include "window_state.h"

namespace vir {
namespace {

ceres::Problem::Options problemOptions() {
  ceres::Problem::Options o;
  o.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  o.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  o.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  o.disable_all_safety_checks = true;
  return o;
}

void addParameters(WindowState& w, ceres::Problem* problem,
                   ceres::ParameterBlockOrdering* ordering) {
  for (auto& f : w.frames) {
    problem->AddParameterBlock(f->pose, 7, &w.pose_manifold);
    problem->AddParameterBlock(f->speed_bias, 9);
    ordering->AddElementToGroup(f->pose, 1);
    ordering->AddElementToGroup(f->speed_bias, 1);
  }
  if (!w.calibrating()) return;
  problem->AddParameterBlock(w.extrinsic, 7, &w.pose_manifold);
  problem->AddParameterBlock(w.time_offset, 1);
  if (!w.options.estimate_extrinsics) problem->SetParameterBlockConstant(w.extrinsic);
  if (!w.options.estimate_time_offset) problem->SetParameterBlockConstant(w.time_offset);
  ordering->AddElementToGroup(w.extrinsic, 1);
  ordering->AddElementToGroup(w.time_offset, 1);
}

/// Saved values, to undo a solution that is not finite.
struct Snapshot {
  explicit Snapshot(const WindowState& w) {
    for (const auto& f : w.frames) {
      values.insert(values.end(), f->pose, f->pose + 7);
      values.insert(values.end(), f->speed_bias, f->speed_bias + 9);
    }
    for (const auto& [id, l] : w.landmarks) values.insert(values.end(), l.x, l.x + 3);
  }
  void restore(WindowState* w) const {
    const double* v = values.data();
    const auto take = [&v](double* out, int n) {
      std::copy(v, v + n, out);
      v += n;
    };
    for (auto& f : w->frames) {
      take(f->pose, 7);
      take(f->speed_bias, 9);
    }
    for (auto& [id, l] : w->landmarks) take(l.x, 3);
  }
  std::vector<double> values;
};

bool finite(const WindowState& w) {
  for (const auto& f : w.frames) {
    for (double x : f->pose) {
      if (!std::isfinite(x)) return false;
    }
    for (double x : f->speed_bias) {
      if (!std::isfinite(x)) return false;
    }
  }
  return true;
}

/// Links whose biases moved far from where they were integrated are integrated again.
void relinearizeLinks(WindowState& w) {
  for (std::size_t k = 1; k < w.frames.size(); ++k) {
    const double* sb = w.frames[k - 1]->speed_bias;
    const Vec3 bg(sb[3], sb[4], sb[5]), ba(sb[6], sb[7], sb[8]);
    Preintegration& link = *w.frames[k]->link;
    if ((bg - link.biasGyro()).norm() > 0.005 || (ba - link.biasAcc()).norm() > 0.1) {
      link.relinearise(bg, ba);
    }
  }
}

std::unique_ptr<ceres::LossFunction> lossOf(const WindowOptions& o) {
  if (o.loss == "cauchy") return std::make_unique<ceres::CauchyLoss>(o.loss_scale);
  return std::make_unique<ceres::HuberLoss>(o.loss_scale);
}

ceres::Solver::Options solverOptions(int iterations) {
  ceres::Solver::Options options;
  options.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  options.max_num_iterations = iterations;
  options.function_tolerance = 1e-5;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  return options;
}

SolveSummary run(WindowState& w, const ceres::Solver::Options& options, const TermSet& set,
                 ceres::Problem* problem) {
  const Snapshot before(w);
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem, &summary);
  SolveSummary out;
  out.iterations = static_cast<int>(summary.iterations.size());
  out.initial_cost = summary.initial_cost;
  out.final_cost = summary.final_cost;
  out.sights = set.sights();
  out.usable =
      finite(w) && std::isfinite(summary.final_cost) && summary.termination_type != ceres::FAILURE;
  if (!out.usable) before.restore(&w);
  double sum = 0;
  double r[2];
  for (const Term& t : set.terms()) {
    if (t.robust <= 0) continue;  // only reprojections have a robust loss
    t.cost->Evaluate(t.blocks.data(), r, nullptr);
    sum += r[0] * r[0] + r[1] * r[1];
  }
  out.reprojection_rms = out.sights ? std::sqrt(sum / (2.0 * out.sights)) : 0;
  return out;
}

}  // namespace

SolveSummary solveWindow(WindowState& w, int iterations) {
  relinearizeLinks(w);
  TermSet set(w);
  set.addAll();

  ceres::Problem problem(problemOptions());
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  const std::unique_ptr<ceres::LossFunction> loss = lossOf(w.options);
  addParameters(w, &problem, ordering.get());
  for (const Term& t : set.terms()) {
    problem.AddResidualBlock(const_cast<ceres::CostFunction*>(t.cost),
                             t.robust > 0 ? loss.get() : nullptr, t.blocks);
    if (t.landmark && t.blocks.size() == 1) ordering->AddElementToGroup(t.landmark, 0);
  }
  ceres::Solver::Options options = solverOptions(iterations);
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = ordering;
  return run(w, options, set, &problem);
}

SolveSummary solveTail(WindowState& w, int iterations, std::size_t first) {
  TermSet set(w);
  set.addTail(first);
  ceres::Problem problem(problemOptions());
  const std::unique_ptr<ceres::LossFunction> loss = lossOf(w.options);
  for (std::size_t k = first > 0 ? first - 1 : 0; k < w.frames.size(); ++k) {
    Frame& f = *w.frames[k];
    problem.AddParameterBlock(f.pose, 7, &w.pose_manifold);
    problem.AddParameterBlock(f.speed_bias, 9);
    if (k >= first) continue;
    problem.SetParameterBlockConstant(f.pose);
    problem.SetParameterBlockConstant(f.speed_bias);
  }
  for (const Term& t : set.terms()) {
    problem.AddResidualBlock(const_cast<ceres::CostFunction*>(t.cost),
                             t.robust > 0 ? loss.get() : nullptr, t.blocks);
  }
  ceres::Solver::Options options = solverOptions(iterations);
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  return run(w, options, set, &problem);
}

}  // namespace vir
