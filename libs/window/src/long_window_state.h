#pragma once
/// Internal: data of the long window, shared by its translation units.
#include <array>
#include <cmath>

#include "chain.h"
#include "vir/factors/node_edge_factor.h"
#include "vir/factors/node_range_difference_factor.h"
#include "vir/factors/node_range_factor.h"
#include "vir/factors/position_link_factor.h"
#include "vir/window/long_window.h"

namespace vir::window {

/// What marginalised nodes left: cost 1/2 d^T H d + b^T d with d = x - lin, over the oldest nodes
/// and the anchors that existed then.
struct LongPrior {
  int nodes = 0;
  std::vector<std::uint64_t> anchors;
  Eigen::MatrixXd H;
  Eigen::VectorXd b, lin;
};

struct LongWindow::Impl {
  explicit Impl(const LongWindowOptions& o) : options(o) {}

  LongWindowOptions options;
  std::deque<LongNode> nodes;
  LongNode head;
  bool started = false;
  std::map<std::uint64_t, AnchorNode> anchors;
  std::vector<SurveyTie> survey;
  std::vector<AnchorDistance> distances;
  LongPrior prior;
  std::vector<LongNode> retired;
  Eigen::Matrix4d claim = Eigen::Matrix4d::Zero();  ///< information; zero: none

  // Of the last elimination.
  std::vector<EliminatedNode> eliminated;
  std::vector<double> before;                       ///< head and anchors then
  std::vector<std::array<double, kNodeSize>> kept;  ///< nodes before a step that may be taken back
  NormalEquations message;
  Eigen::MatrixXd joint;
  std::vector<std::uint64_t> joint_anchors;

  bool position() const { return options.mode == LongWindowMode::position; }
  int band() const { return position() ? 3 : 1; }
  int limit() const { return options.mode == LongWindowMode::none ? 0 : options.size; }
  int anchorIndex(std::uint64_t id) const;
  bool yawFrozen() const { return position() || !options.heading; }
  bool scaleFrozen() const { return position() || options.scale_sigma <= 0; }
  LongNode& node(std::size_t k) { return k < nodes.size() ? nodes[k] : head; }

  /// The residual of a range that a node (or the head) holds, and its Jacobians unless null.
  void evaluate(const HeldRange& r, const factors::NodeFrame& node, const AnchorNode& a,
                double* residual, double* J_node, double* J_anchor) const {
    const factors::RangeTerm term{
        r.range_m, r.sigma_m * std::sqrt(a.variance_factor) / options.gamma_r, options.robust};
    factors::evaluateNodeRange(term, node, options.ranges_at_own_time ? r.motion : Vec3::Zero(),
                               r.lever, a.x, residual, J_node, J_anchor);
  }
  /// The residual of a difference that a node (or the head) holds, between two known anchors.
  factors::NodeRangeDifferenceFactor differenceOf(const HeldRange& r, const AnchorNode& a,
                                                  const AnchorNode& reference) const {
    const double factor = std::max(a.variance_factor, reference.variance_factor);
    const factors::RangeTerm term{r.range_m, r.sigma_m * std::sqrt(factor) / options.gamma_r,
                                  options.robust};
    return {term, options.ranges_at_own_time ? r.motion : Vec3(Vec3::Zero()), r.lever};
  }
  void addDifference(const LongNode& n, const HeldRange& r, Frontal* f) const;
  void addPrior(Frontal* f) const;
  void addAnchorPriors(Frontal* f) const;
  // anchor_ties.cpp: what ties anchors to one another.
  LevelFit surveyFit() const;
  void addSurvey(Frontal* f) const;
  void addDistances(Frontal* f) const;
  double costOfTies() const;
  factors::RangePrediction predictDistance(const AnchorDistance& d, const AnchorNode& a,
                                           const AnchorNode& b) const;
  void addNode(std::size_t k, Frontal* f);
  void addRanges(const LongNode& n, const std::vector<HeldRange>& ranges, Frontal* f) const;
  void addClaim(Frontal* f) const;
  void holdFrozen(Frontal* f) const;
  void holdFixedAnchors(Frontal* f) const;
  /// Mode "position": ties the new head to the nodes before it.
  void linkHead();
  void marginaliseOldest();
  std::vector<double> headAndAnchors() const;
  /// What the cost depends on, and nothing that was worked out of it.
  void takeStateOf(const Impl& other);
  void keepNodes();
  void restoreNodes();
  double cost(const std::vector<HeldRange>& head_ranges);
};

}  // namespace vir::window
