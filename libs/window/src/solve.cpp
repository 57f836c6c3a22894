#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "window_state.h"

namespace vir::window {
namespace {

ceres::Problem::Options problemOptions() {
  ceres::Problem::Options o;
  o.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  o.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  o.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  o.disable_all_safety_checks = true;
  return o;
}

/// A copy of what is solved for, in window order in one array: Ceres orders by address, so that the
/// rounding of a result would else depend on where the heap happened to put a landmark. Only a
/// solution that is finite is written back.
class Unknowns {
 public:
  explicit Unknowns(WindowState& w) {
    const std::size_t anchors = w.ranging() ? 1 + w.long_window->anchors().size() : 0;
    const std::size_t blocks = 2 * w.frames.size() + 3 + w.landmarks.size() + anchors;
    entries_.reserve(blocks);
    index_.reserve(blocks);
    for (auto& f : w.frames) {
      add(f->pose, 7);
      add(f->speed_bias, 9);
    }
    add(w.extrinsic, 7);
    add(w.camera_parameters, factors::kCameraParameters);
    add(w.imu_intrinsics, imu::kImuIntrinsicsSize);
    for (auto& [id, l] : w.landmarks) add(l.x, 3);
    if (w.ranging()) {
      add(w.long_window->headParameters(), 5);
      for (auto& [id, a] : w.long_window->anchors()) add(w.long_window->anchor(id)->x, 4);
    }
    values_.reserve(size_);
    for (const Entry& e : entries_) values_.insert(values_.end(), e.original, e.original + e.size);
  }
  double* of(double* original) { return values_.data() + index_.at(original); }
  std::vector<double*> of(std::vector<double*> originals) {
    for (double*& x : originals) x = of(x);
    return originals;
  }
  bool finite() const {
    return std::all_of(values_.begin(), values_.end(), [](double x) { return std::isfinite(x); });
  }
  void writeBack() const {
    const double* v = values_.data();
    for (const Entry& e : entries_) {
      std::copy(v, v + e.size, e.original);
      v += e.size;
    }
  }

 private:
  struct Entry {
    double* original;
    int size;
  };
  void add(double* x, int size) {
    entries_.push_back({x, size});
    index_[x] = size_;
    size_ += static_cast<std::size_t>(size);
  }
  std::vector<Entry> entries_;
  std::unordered_map<const double*, std::size_t> index_;  // looked up only
  std::size_t size_ = 0;
  std::vector<double> values_;
};

/// Nothing where the whole camera is free.
std::unique_ptr<ceres::Manifold> cameraManifold(const WindowState& w) {
  if (!w.calibrating() || !w.lens_held) return nullptr;
  return std::make_unique<ceres::SubsetManifold>(
      factors::kCameraParameters, std::vector<int>{factors::kRadial1, factors::kRadial2});
}

void addParameters(WindowState& w, ceres::Manifold* camera_manifold, Unknowns* x,
                   ceres::Problem* problem, ceres::ParameterBlockOrdering* ordering) {
  for (auto& f : w.frames) {
    problem->AddParameterBlock(x->of(f->pose), 7, &w.pose_manifold);
    problem->AddParameterBlock(x->of(f->speed_bias), 9);
    ordering->AddElementToGroup(x->of(f->pose), 1);
    ordering->AddElementToGroup(x->of(f->speed_bias), 1);
  }
  if (!w.calibrating()) return;
  double* const extrinsic = x->of(w.extrinsic);
  double* const camera = x->of(w.camera_parameters);
  problem->AddParameterBlock(extrinsic, 7, &w.pose_manifold);
  problem->AddParameterBlock(camera, factors::kCameraParameters, camera_manifold);
  ordering->AddElementToGroup(extrinsic, 1);
  ordering->AddElementToGroup(camera, 1);
  double* const imu = x->of(w.imu_intrinsics);
  problem->AddParameterBlock(imu, imu::kImuIntrinsicsSize);
  ordering->AddElementToGroup(imu, 1);
}

/// The head of the long window and the anchors.
void addRangeParameters(WindowState& w, const ceres::Manifold* head_manifold, Unknowns* x,
                        ceres::Problem* problem, ceres::ParameterBlockOrdering* ordering) {
  double* const head = x->of(w.long_window->headParameters());
  problem->AddParameterBlock(head, 5, const_cast<ceres::Manifold*>(head_manifold));
  ordering->AddElementToGroup(head, 1);
  for (const auto& [id, a] : w.long_window->anchors()) {
    double* const anchor = x->of(w.long_window->anchor(id)->x);
    problem->AddParameterBlock(anchor, 4);
    if (a.fixed) problem->SetParameterBlockConstant(anchor);
    ordering->AddElementToGroup(anchor, 1);
  }
}

/// The long window follows what the solution did to its head.
void updateLongWindow(WindowState& w) {
  if (!w.long_window || w.long_window->empty()) return;
  if (w.ranging()) w.long_window->backSubstitute();
  const Frame& oldest = *w.frames.front();
  w.long_window->headMoved(oldest.t, oldest.T_W_B());
}

/// Links whose biases or intrinsics moved far from where they were integrated are integrated again.
void relinearizeLinks(WindowState& w) {
  for (std::size_t k = 1; k < w.frames.size(); ++k) {
    const double* sb = w.frames[k - 1]->speed_bias;
    const Vec3 bg(sb[3], sb[4], sb[5]), ba(sb[6], sb[7], sb[8]);
    imu::Preintegration& link = *w.frames[k]->link;
    if ((bg - link.biasGyro()).norm() > 0.005 || (ba - link.biasAcc()).norm() > 0.1 ||
        (w.imuIntrinsics() - link.intrinsics()).norm() > 0.004) {
      link.relinearise(bg, ba, w.imuIntrinsics());
    }
  }
}

/// Holds what the long window's options freeze; nullptr if all is free.
std::unique_ptr<ceres::Manifold> headManifold(const WindowState& w) {
  if (!w.ranging()) return nullptr;
  const std::vector<int> frozen = w.long_window->frozen();
  if (frozen.empty()) return nullptr;
  return std::make_unique<ceres::SubsetManifold>(5, frozen);
}

std::unique_ptr<ceres::LossFunction> lossOf(const WindowOptions& o) {
  if (o.loss == ReprojectionLoss::cauchy) return std::make_unique<ceres::CauchyLoss>(o.loss_scale);
  return std::make_unique<ceres::HuberLoss>(o.loss_scale);
}

ceres::Solver::Options solverOptions(int iterations) {
  ceres::Solver::Options options;
  options.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  options.max_num_iterations = iterations;
  options.function_tolerance = 1e-5;
  // Hardly damped: Ceres' default (1e4) holds back what is weakly observed, scale and calibration,
  // and two iterations never catch up. A step that makes things worse is taken back all the same.
  options.initial_trust_region_radius = 1e8;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  return options;
}

SolveSummary run(const ceres::Solver::Options& options, const TermSet& set, Unknowns* x,
                 ceres::Problem* problem) {
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem, &summary);
  SolveSummary out;
  out.iterations = static_cast<int>(summary.iterations.size());
  out.initial_cost = summary.initial_cost;
  out.final_cost = summary.final_cost;
  out.sights = set.sights();
  out.usable = x->finite() && std::isfinite(summary.final_cost) &&
               summary.termination_type != ceres::FAILURE;
  if (out.usable) x->writeBack();
  double sum = 0, inertial = 0;
  int links = 0;
  for (const Term& t : set.terms()) {
    if (t.cost->num_residuals() == 15 && t.blocks.size() >= 4 && t.blocks.size() <= 5) {
      imu::Vec15 r;
      t.cost->Evaluate(t.blocks.data(), r.data(), nullptr);
      inertial += r.head<9>().squaredNorm();
      ++links;
    }
    if (t.robust <= 0) continue;  // only reprojections have a robust loss
    double r[2];
    t.cost->Evaluate(t.blocks.data(), r, nullptr);
    sum += r[0] * r[0] + r[1] * r[1];
  }
  out.inertial_rms = links ? std::sqrt(inertial / (9.0 * links)) : 0;
  out.reprojection_rms = out.sights ? std::sqrt(sum / (2.0 * out.sights)) : 0;
  return out;
}

}  // namespace

void SightLevel::add(double rms, int sights) {
  constexpr int kFewestSights = 200, kMemory = 20;
  if (sights < kFewestSights || !std::isfinite(rms)) return;
  solutions = std::min(solutions + 1, kMemory);
  mean_square += (rms * rms - mean_square) / solutions;
}

SolveSummary solveWindow(WindowState& w, int iterations) {
  relinearizeLinks(w);
  TermSet set(w);
  set.addAllWithRanges();

  ceres::Problem problem(problemOptions());
  const std::unique_ptr<ceres::Manifold> head_manifold = headManifold(w);
  const std::unique_ptr<ceres::Manifold> camera_manifold = cameraManifold(w);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  const std::unique_ptr<ceres::LossFunction> loss = lossOf(w.options);
  Unknowns x(w);
  addParameters(w, camera_manifold.get(), &x, &problem, ordering.get());
  if (w.ranging()) addRangeParameters(w, head_manifold.get(), &x, &problem, ordering.get());
  for (const Term& t : set.terms()) {
    problem.AddResidualBlock(const_cast<ceres::CostFunction*>(t.cost),
                             t.robust > 0 ? loss.get() : nullptr, x.of(t.blocks));
    if (t.landmark && t.blocks.size() == 1) ordering->AddElementToGroup(x.of(t.landmark), 0);
  }
  ceres::Solver::Options options = solverOptions(iterations);
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = ordering;
  const SolveSummary out = run(options, set, &x, &problem);
  if (out.usable) w.sight_level.add(out.reprojection_rms, out.sights);
  if (out.usable) updateLongWindow(w);
  return out;
}

SolveSummary solveTail(WindowState& w, int iterations, std::size_t first) {
  TermSet set(w);
  set.addTail(first);
  ceres::Problem problem(problemOptions());
  const std::unique_ptr<ceres::LossFunction> loss = lossOf(w.options);
  Unknowns x(w);
  for (std::size_t k = first > 0 ? first - 1 : 0; k < w.frames.size(); ++k) {
    Frame& f = *w.frames[k];
    problem.AddParameterBlock(x.of(f.pose), 7, &w.pose_manifold);
    problem.AddParameterBlock(x.of(f.speed_bias), 9);
    if (k >= first) continue;
    problem.SetParameterBlockConstant(x.of(f.pose));
    problem.SetParameterBlockConstant(x.of(f.speed_bias));
  }
  for (const Term& t : set.terms()) {
    problem.AddResidualBlock(const_cast<ceres::CostFunction*>(t.cost),
                             t.robust > 0 ? loss.get() : nullptr, x.of(t.blocks));
  }
  ceres::Solver::Options options = solverOptions(iterations);
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  return run(options, set, &x, &problem);
}

}  // namespace vir::window
