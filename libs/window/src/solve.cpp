#include <algorithm>
#include <cmath>

#include "window_state.h"

namespace vir::window {
namespace {

/// Speeds and biases, from the newest on (they are eliminated first), then poses and calibration.
LeastSquares windowProblem(WindowState& w) {
  LeastSquares out;
  // Of two steps per keyframe the second must be another one: a rig's solves refused both for five
  // keyframes in a row, and the window went astray (rendered eight: 0.032 m, 0.009 so).
  constexpr double kRefusedRadius = 100;
  if (!w.further.empty()) out.refused_radius = kRefusedRadius;
  out.order = leadingOrder(w, &out.leading);
  if (!w.calibrating() || !w.lens_held) return out;
  int column = 0;
  for (const BlockRef& b : out.order) {
    bool lens = b.data == w.camera_parameters;
    for (const FurtherCamera& c : w.further) lens = lens || b.data == c.parameters;
    if (lens) {
      out.held.push_back(column + factors::kRadial1);
      out.held.push_back(column + factors::kRadial2);
    }
    column += b.local();
  }
  return out;
}

/// The head of the long window and the anchors.
void addRangeBlocks(WindowState& w, LeastSquares* problem) {
  int column = 0;
  for (const BlockRef& b : problem->order) column += b.local();
  LongWindow& lw = *w.long_window;
  problem->order.push_back({lw.headParameters(), 5, 0, nullptr});
  for (const int i : lw.frozen()) problem->held.push_back(column + i);
  column += 5;
  for (const auto& [id, a] : lw.anchors()) {
    problem->order.push_back({lw.anchor(id)->x, 4, 0, nullptr});
    for (int i = 0; i < 4 && a.fixed; ++i) problem->held.push_back(column + i);
    column += 4;
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

SolveSummary summaryOf(const Minimised& m, const TermSet& set) {
  SolveSummary out;
  out.iterations = m.iterations;
  out.initial_cost = m.initial_cost;
  out.final_cost = m.sums.cost;
  out.sights = set.sights();
  out.usable = m.usable;
  const TermSums& s = m.sums;
  out.inertial_rms = s.links ? std::sqrt(s.link_squares / (9.0 * s.links)) : 0;
  out.reprojection_rms = out.sights ? std::sqrt(s.sight_squares / (2.0 * out.sights)) : 0;
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
  w.moved_from = 0;
  TermSet set(w), ranges(w);
  set.addAll();
  LeastSquares problem = windowProblem(w);
  problem.terms = &set.terms();
  if (w.ranging()) {
    ranges.addRanges();
    addRangeBlocks(w, &problem);
    problem.further = &ranges.terms();
  }
  const SolveSummary out = summaryOf(w.minimiser.minimise(problem, iterations), set);
  w.information_known = out.usable;
  if (out.usable) w.sight_level.add(out.reprojection_rms, out.sights);
  if (out.usable) updateLongWindow(w);
  return out;
}

SolveSummary solveTail(WindowState& w, int iterations, std::size_t first) {
  TermSet set(w);
  set.addTail(first);
  LeastSquares problem;
  problem.order = frameBlocks(w, first, w.frames.size() - first);
  problem.terms = &set.terms();
  w.information_known = false;
  w.moved_from = std::min(w.moved_from, first);
  return summaryOf(w.tail_minimiser.minimise(problem, iterations), set);
}

}  // namespace vir::window
