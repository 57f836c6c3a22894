#pragma once
/// The long window Omega (paper, section "Double Layer Tightly Coupled VIR Optimization"): the
/// keyframes that left the short window, the ranges measured there, and the anchors.
///
/// Frames: O is the odometry's own frame (the short window's, or a tracking camera's), which
/// drifts; W is the world the ranges hold in place. A node says where one keyframe is in W and how
/// O is turned in W there. The youngest node, the head, is the oldest frame of the short window:
/// what the ranges say reaches the newest pose through it.
#include <Eigen/Core>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "vir/core/options.h"
#include "vir/core/time.h"
#include "vir/factors/range_factor.h"
#include "vir/geometry/level_transform.h"
#include "vir/geometry/pose.h"
#include "vir/window/marginalization.h"

namespace vir::window {

enum class LongWindowMode {
  none,      ///< nodes are folded into the prior at once
  position,  ///< the paper's formulation as written
  pose       ///< nodes have a heading, edges are conditional
};

struct LongWindowOptions {
  LongWindowMode mode = LongWindowMode::pose;
  int size = 100;
  bool anchor_fixed_after_init = false;
  bool conditional_edges = true;
  bool heading = true;
  bool gauge_free_prior = true;
  bool ranges_at_own_time = true;
  bool noise_from_residuals = true;
  double edge_noise_scale = 0.85;
  double edge_sigma_m = 0.01;
  double edge_sigma_rad = 0.002;
  double gamma_r = 1.0;
  double gamma_s = 100.0;
  double scale_sigma = 0.0;
  double scale_walk_per_sqrt_m = 0.0;
  ranging::RobustRange robust;

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
/// Section [LongWindow]; mode, size and anchor_fixed_after_init are keys of [Estimator]:
void describe(OptionVisitor& v, LongWindowOptions& o);
/// long_window, long_window_size and anchor, in whatever section is open.
void describeMode(OptionVisitor& v, LongWindowOptions& o);

/// A range that belongs to a keyframe; vectors in the axes of what holds it: O for a node of the
/// long window, the body for a frame of the short one.
struct HeldRange {
  TimeNs t = 0;
  std::uint64_t anchor = 0;
  double range_m = 0;
  double sigma_m = 0.1;        ///< of this range alone
  Vec3 motion = Vec3::Zero();  ///< what the body moved from its keyframe's time to t [m]
  Vec3 lever = Vec3::Zero();   ///< antenna against the body then [m]
  int merged = 1;              ///< ranges averaged in this one
  /// Set: `range_m` is the range to `anchor` less that to this one.
  std::optional<std::uint64_t> reference = std::nullopt;
};

/// Averages neighbours (same anchor, same reference) until at most `limit` ranges per anchor are
/// left: a robot that stands still would pile them up on one keyframe. The average is never taken
/// as better than a quarter of one range's sigma: errors at one place are alike.
void mergeRanges(std::vector<HeldRange>* ranges, std::size_t limit);

/// An anchor's state: position in W and the constant bias of its ranges.
struct AnchorNode {
  std::uint64_t id = 0;
  double x[4] = {0, 0, 0, 0};
  Eigen::Vector4d prior_mean = Eigen::Vector4d::Zero();
  Eigen::Matrix4d prior_information = Eigen::Matrix4d::Zero();
  double variance_factor = 1;  ///< correlated ranges carry less: their variance times this
  bool fixed = false;
  bool settled = true;  ///< false: its ranges move the short window as a whole, but do not bend it
  Vec3 position() const { return {x[0], x[1], x[2]}; }
};

/// An anchor at a surveyed position, in the survey's frame S (z up), whose place in W nobody knows.
struct SurveyTie {
  std::uint64_t anchor = 0;
  Vec3 p_S = Vec3::Zero();  ///< [m]
  double sigma_m = 0.05;
};

/// How far two anchors are from one another, as they have measured it themselves.
struct AnchorDistance {
  std::uint64_t first = 0, second = 0;
  double range_m = 0;
  double sigma_m = 0.1;  ///< of their biases and the noise together
};

/// Whether the odometry was followed from one node to the next.
enum class NodeTie {
  followed,
  lost,  ///< it was not: nothing ties the two but how far it can have got meanwhile
};

/// Mode "position": a virtual measurement from a node to a later one, gamma (p_b - p_a - z).
struct PositionLink {
  Vec3 z_W = Vec3::Zero();
  double gamma = 0;  ///< [1/m]
};

struct LongNode {
  TimeNs t = 0;
  double x[5] = {0, 0, 0, 0, 0};  ///< p_W_B, yaw of O in W, log scale
  Pose T_O_B;                     ///< as the odometry last saw it
  std::vector<HeldRange> ranges;
  // Edge to the next node.
  Vec3 motion_O = Vec3::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();
  Eigen::Matrix4d sqrt_information = Eigen::Matrix4d::Identity();
  double sigma_log_scale = 1e-6;
  NodeTie tie = NodeTie::followed;
  std::vector<PositionLink> links;  ///< mode "position": to the next s nodes

  Vec3 position() const { return {x[0], x[1], x[2]}; }
  Pose T_W_B() const;
};

/// Those of `ranges`, held by `node`, that are wanted, each with its antenna's place in W [m] for
/// `motion`, and no lever.
void addHeldInWorld(const LongNode& node, const std::vector<HeldRange>& ranges,
                    const std::function<bool(const HeldRange&)>& wanted,
                    std::vector<HeldRange>* out);

class LongWindow {
 public:
  explicit LongWindow(const LongWindowOptions& options);
  ~LongWindow();

  /// Begins with a head at `T_W_B` whose odometry pose is T_O_B. Standard deviations of what is
  /// known of its position [m] and yaw [rad] in W.
  void start(TimeNs t, const Pose& T_O_B, const Pose& T_W_B, double sigma_m, double sigma_rad);
  bool empty() const;
  void clear();

  /// The head becomes an ordinary node with these ranges, and a new head follows it.
  /// `covariance` [4x4] of (motion in O, yaw) from the old head to the new one. After a `lost` tie
  /// it alone holds them together, whatever the options say of edges.
  void advance(TimeNs t, const Pose& T_O_B, std::vector<HeldRange> head_ranges,
               const Eigen::Matrix4d& covariance, NodeTie tie = NodeTie::followed);

  /// The odometry now has the head elsewhere in O. What it learnt belongs to the way travelled:
  /// spread over the edges by their variance.
  void headMoved(TimeNs t, const Pose& T_O_B);
  /// gauge_free_prior = false only: the odometry's claim to know position and yaw in O, covariance
  /// [4x4] of (position, yaw). Kept to show what it does: it fights the ranges.
  void setOdometryClaim(const Eigen::Matrix4d& covariance);

  /// What all nodes before the head, their edges and ranges, and the priors say about (head,
  /// anchors), around the current values. Linear in the number of nodes.
  const NormalEquations& eliminate();
  /// After head and anchors have been changed: moves all nodes before the head accordingly
  /// (back-substitution of the last eliminate()).
  void backSubstitute();
  /// Gauss-Newton on everything, with `head_ranges` at the head, for an odometry without short
  /// window. False if the result is not finite (nothing changed then).
  bool solve(int iterations, const std::vector<HeldRange>& head_ranges);

  /// What everything would cost (twice the loss) if the anchor were at `p_W`: solved on a copy,
  /// from there. `ends_at`: the solution's position. Infinite if it does not solve.
  double costWithAnchorAt(std::uint64_t id, const Vec3& p_W, int iterations,
                          const std::vector<HeldRange>& head_ranges, Vec3* ends_at) const;

  /// A pose, and a vector, of the odometry in W.
  Pose toWorld(const Pose& T_O_B) const;
  Vec3 pointToWorld(const Vec3& p_O) const;
  Vec3 turnToWorld(const Vec3& v_O) const;
  /// An antenna at `p_O`, of which `lever_O` is the lever arm: that is as long in W as it is in O,
  /// whatever the odometry's scale.
  Vec3 antennaToWorld(const Vec3& p_O, const Vec3& lever_O) const;

  /// What ties anchors to one another, whatever the path; those that are no anchors (yet, or any
  /// more) are passed over. Each call replaces what there was.
  void setSurvey(std::vector<SurveyTie> ties);
  void setAnchorDistances(std::vector<AnchorDistance> distances);
  const std::vector<SurveyTie>& survey() const;
  /// T_S_W by the anchors that the survey ties, where they are now.
  LevelFit surveyFit() const;

  // Anchors, ordered by id.
  AnchorNode& addAnchor(std::uint64_t id, const Eigen::Vector4d& mean,
                        const Eigen::Matrix4d& covariance);
  void removeAnchor(std::uint64_t id);
  AnchorNode* anchor(std::uint64_t id);
  const std::map<std::uint64_t, AnchorNode>& anchors() const;

  double* headParameters();
  /// Entries of a node that the options hold fixed (yaw, scale).
  std::vector<int> frozen() const;
  /// How O is turned in W, and the odometry's scale, are not estimated.
  bool yawFrozen() const;
  bool scaleFrozen() const;
  const LongNode& head() const;
  const std::deque<LongNode>& nodes() const;  ///< before the head, oldest first
  std::vector<LongNode> takeRetired();

  /// Joint covariance of (head [5], anchors [4 each, in order of id]) when last updated.
  void setJointInformation(const NormalEquations& eq);
  const Eigen::MatrixXd& jointCovariance() const;
  /// Column of an anchor in it; -1 if it was not there then.
  int columnOf(std::uint64_t id) const;

  /// A range as its factor needs it: sigma with the anchor's factor for correlated ranges.
  factors::RangeTerm termOf(std::uint64_t anchor, double range_m, double sigma_m) const;
  const LongWindowOptions& options() const;

 private:
  struct Impl;
  /// The cost when it has ended; empty, and nothing changed, if a step is not finite. `last`: the
  /// normal equations of (head, anchors) of the last step.
  std::optional<double> minimise(int iterations, const std::vector<HeldRange>& head_ranges,
                                 NormalEquations* last);
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::window
