#include "vir/estimator/odometry_range_estimator.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>

#include "old_keyframes.h"
#include "start_sigma.h"
#include "vir/core/stage_timer.h"
#include "vir/core/time_bounds.h"
#include "vir/types/unseen_motion.h"

namespace vir::estimator {
namespace {

/// Standard deviations that say "we do not know" when the odometry jumped.
constexpr double kJumpPosition = 1.0, kJumpYaw = 0.3;
/// A silence that is so much longer than usual, and this long [s], is a gap.
constexpr double kUnusual = 10, kShortestGap_s = 1;
/// Stamps jitter: a step up to this is no jump, however short the time [m].
constexpr double kStepAlways = 0.2;
/// Solver iterations when an anchor has just been found or changed.
constexpr int kIterationsOnChange = 15;
/// Ranges of one anchor that the head holds before neighbours are averaged.
constexpr std::size_t kMaxRangesPerNode = 16;

/// What lies between the head and the newest pose: what its uncertainty grows with.
struct Travelled {
  double metres = 0, radians = 0;
  double gap_s = 0;  ///< without odometry
};

}  // namespace

OdometryNoise odometryNoiseDefaults() {
  OdometryNoise o;
  o.sigma_per_sqrt_m = 0.05;
  o.sigma_per_rad_m = 0.005;
  o.yaw_per_sqrt_m = 0.015;
  o.yaw_per_sqrt_rad = 0.01;
  o.yaw_per_sqrt_s = 0.0005;
  o.vertical_share = 0.5;
  return o;
}

void describe(OptionVisitor& v, OdometryOptions& o) {
  v.section("Odometry", "Poses from a device: how they err, and how often one becomes a node");
  v.value("node_distance_m", o.node_distance_m, {0.01, 100.0}, "distance between nodes");
  v.value("node_turn_rad", o.node_turn_rad, {0.01, 10.0}, "turn between nodes");
  v.value("node_interval_s", o.node_interval_s, {0.05, 1e4}, "longest time between nodes");
  describe(v, o.noise);
  v.value("max_step_m", o.max_step_m, {0.01, 1e4}, "a longer step between two poses is a jump");
  v.value("max_speed_mps", o.max_speed_mps, {0.1, 1e4}, "and a step that takes more speed");
  v.value("max_gap_s", o.max_gap_s, {0.01, 1e4}, "a longer time between two poses is a gap");
}

window::LongWindowOptions odometryWindowDefaults() {
  window::LongWindowOptions o;
  o.size = 400;
  o.edge_noise_scale = 1.0;
  o.scale_sigma = 0.05;
  o.scale_walk_per_sqrt_m = 0.004;
  return o;
}

RangeOptions odometryRangeDefaults() {
  RangeOptions o;
  o.max_anchor_sigma_m = 3.0;
  o.drift_ratio = 0.05;
  o.bias_sigma_m = 0.05;
  return o;
}

void describe(OptionVisitor& v, OdometryRangeConfig& o) {
  describe(v, o.odometry);
  describe(v, o.long_window);
  describe(v, o.ranges);
}

struct OdometryRangeEstimator::Impl {
  Impl(const OdometryRangeConfig& c, LogSink l)
      : config(c),
        log_sink(std::move(l)),
        window(c.long_window),
        ranges(c.ranges, &window, log_sink) {}

  void process(TimeNs t, const Pose& T_O_B);
  bool plausible(TimeNs t, const Pose& T_O_B);
  void attachRanges(TimeNs t, const Pose& T_O_B);
  void advance(TimeNs t, const Pose& T_O_B);
  void bridge(double seconds);
  Eigen::Matrix4d covarianceOf(const Travelled& travelled, double seconds) const;
  std::vector<window::HeldRange> heldWhere(
      const std::function<bool(const window::HeldRange&)>& wanted) const;
  std::vector<window::HeldRange> heldRanges(std::uint64_t key) const;
  std::vector<window::HeldRange> heldDifferences() const;
  Eigen::Matrix<double, 6, 6> covarianceInWorld(const Pose& T_W_B) const;
  void warn(const std::string& text) {
    log(log_sink, LogLevel::warning, text);
    warnings.push_back(text);
  }
  void collectRangeWarnings() {
    for (const std::string& w : ranges.takeWarnings()) warnings.push_back(w);
  }

  OdometryRangeConfig config;
  LogSink log_sink;
  window::LongWindow window;
  RangeLayer ranges;
  std::vector<window::HeldRange> head_ranges;
  std::vector<StateEstimate> results;
  OldKeyframes retired;
  std::vector<std::string> warnings;
  TimeNs last_t = 0;
  Pose last;
  Travelled travelled;
  bool jumped = false;
  int segment = 0;
  bool gap_warned = false;
  double usual_s = 0;  ///< between two poses
  long poses = 0, not_finite = 0, bad_stamps = 0, out_of_order = 0, jumps = 0, gaps = 0;
};

bool OdometryRangeEstimator::Impl::plausible(TimeNs t, const Pose& T_O_B) {
  ++poses;
  const double norm = T_O_B.q.norm();
  if (!T_O_B.p.allFinite() || !std::isfinite(norm) || std::abs(norm - 1) > 1e-2) {
    ++not_finite;
    return false;
  }
  if (!isStamp(t)) {
    ++bad_stamps;
    return false;
  }
  if (!window.empty() && t <= last_t) {
    ++out_of_order;
    return false;
  }
  ranges.begin(t);
  return true;
}

Eigen::Matrix4d OdometryRangeEstimator::Impl::covarianceOf(const Travelled& done,
                                                           double seconds) const {
  const OdometryNoise& noise = config.odometry.noise;
  const double p = noise.positionVariance(done.metres, done.radians, seconds) + 1e-6 +
                   unseenPositionVariance(done.gap_s);
  const double yaw =
      noise.yawVariance(done.metres, done.radians, seconds) + 1e-10 + unseenYawVariance(done.gap_s);
  const double share = noise.usableVerticalShare();
  return Eigen::Vector4d(p, p, p * share * share, yaw).asDiagonal();
}

void OdometryRangeEstimator::Impl::attachRanges(TimeNs t, const Pose& T_O_B) {
  const Pose& head = window.head().T_O_B;
  std::vector<Range> late;
  for (const Range& r : ranges.dueUntil(t)) {
    if (r.t < last_t - fromSeconds(0.5)) {
      late.push_back(r);
      continue;
    }
    const double u = std::clamp(toSeconds(r.t - last_t) / toSeconds(t - last_t), 0.0, 1.0);
    const Pose at(last.q.slerp(u, T_O_B.q), last.p + u * (T_O_B.p - last.p));
    window::HeldRange held;
    held.motion = at.p - head.p;
    held.lever = at.q * r.p_B_U;
    AntennaPrediction antenna;
    const Mat3 R_W_O = rotZ(window.head().x[3]);
    antenna.p_W = window.pointToWorld(at.p) + R_W_O * held.lever;
    antenna.inner_covariance =
        covarianceOf(travelled, toSeconds(t - window.head().t)).topLeftCorner<3, 3>();
    if (ranges.accept(r, antenna, &held)) head_ranges.push_back(held);
  }
  ranges.discard(late, RangeDecision::too_late);
  window::mergeRanges(&head_ranges, kMaxRangesPerNode);
}

std::vector<window::HeldRange> OdometryRangeEstimator::Impl::heldWhere(
    const std::function<bool(const window::HeldRange&)>& wanted) const {
  std::vector<window::HeldRange> out;
  for (const window::LongNode& n : window.nodes()) addHeldInWorld(n, n.ranges, wanted, &out);
  addHeldInWorld(window.head(), head_ranges, wanted, &out);
  return out;
}

std::vector<window::HeldRange> OdometryRangeEstimator::Impl::heldRanges(std::uint64_t key) const {
  return heldWhere([key](const window::HeldRange& r) { return r.anchor == key && !r.reference; });
}

std::vector<window::HeldRange> OdometryRangeEstimator::Impl::heldDifferences() const {
  return heldWhere([](const window::HeldRange& r) { return r.reference.has_value(); });
}

void OdometryRangeEstimator::Impl::advance(TimeNs t, const Pose& T_O_B) {
  Eigen::Matrix4d covariance = covarianceOf(travelled, toSeconds(t - window.head().t));
  if (jumped) {
    covariance.diagonal().head<3>().array() += kJumpPosition * kJumpPosition;
    covariance(3, 3) += kJumpYaw * kJumpYaw;
  }
  window.advance(t, T_O_B, std::move(head_ranges), covariance,
                 jumped ? window::NodeTie::lost : window::NodeTie::followed);
  jumped = false;
  head_ranges.clear();
  travelled = Travelled();
  for (const window::LongNode& n : window.takeRetired())
    retired.add({{n.t, n.T_W_B()}, n.T_O_B, 1, Vec3::Zero(), Eigen::Vector4d::Zero()});
  const auto held = [this](std::uint64_t key) { return heldRanges(key); };
  // The covariances must know the new node before ranges are judged by them.
  window.solve(config.iterations, head_ranges);
  const auto differences = [this] { return heldDifferences(); };
  if (ranges.update(t, held, head_ranges, differences))
    window.solve(kIterationsOnChange, head_ranges);
  collectRangeWarnings();
}

Eigen::Matrix<double, 6, 6> OdometryRangeEstimator::Impl::covarianceInWorld(
    const Pose& T_W_B) const {
  Eigen::Matrix<double, 6, 6> out = Eigen::Matrix<double, 6, 6>::Zero();
  const Eigen::MatrixXd& joint = window.jointCovariance();
  if (joint.rows() < 5) return out;
  const Vec3 arm = T_W_B.p - window.head().position();
  Eigen::Matrix<double, 6, 5> J = Eigen::Matrix<double, 6, 5>::Zero();
  J.topLeftCorner<3, 3>().setIdentity();
  J.block<3, 1>(0, 3) = Vec3::UnitZ().cross(arm);
  J.block<3, 1>(0, 4) = -arm;
  J.block<3, 1>(3, 3) = T_W_B.R().row(2).transpose();
  const Eigen::Matrix4d own = covarianceOf(travelled, toSeconds(last_t - window.head().t));
  out = J * joint.topLeftCorner<5, 5>() * J.transpose();
  out.topLeftCorner<3, 3>() += own.topLeftCorner<3, 3>();
  const Vec3 up_B = T_W_B.R().row(2).transpose();
  out.bottomRightCorner<3, 3>() += own(3, 3) * up_B * up_B.transpose();
  return out;
}

/// A node ends where the odometry stopped: what the robot did then is known by the ranges.
void OdometryRangeEstimator::Impl::bridge(double seconds) {
  ++gaps;
  if (!gap_warned) {
    warn("no odometry for " + std::to_string(seconds) + " s at " + std::to_string(last_t) +
         " ns: it may not have counted what the robot did meanwhile");
  }
  gap_warned = true;
  if (last_t > window.head().t) advance(last_t, last);
  travelled.gap_s += seconds;
}

void OdometryRangeEstimator::Impl::process(TimeNs t, const Pose& T_O_B) {
  StateEstimate out;
  out.t_image = out.state.t = t;
  {
    StageTimer timer(&out.ms.total);
    if (window.empty()) {
      window.start(t, T_O_B, T_O_B, kStartSigma, kStartSigma);
      window.solve(1, {});
      ranges.discard(ranges.dueUntil(t), RangeDecision::before_the_start);
      out.keyframe = true;
    } else {
      const double step = (T_O_B.p - last.p).norm(), seconds = toSeconds(t - last_t);
      const double fastest = kStepAlways + config.odometry.max_speed_mps * seconds;
      if (step > std::min(config.odometry.max_step_m, fastest)) {
        ++jumps;
        jumped = true;
        ++segment;
        warn("the odometry jumped by " + std::to_string(step) + " m at " + std::to_string(t) +
             " ns: taken as lost there");
      } else if (seconds > std::min(config.odometry.max_gap_s,
                                    std::max(kShortestGap_s, kUnusual * usual_s))) {
        bridge(seconds);
      } else {
        usual_s = usual_s == 0 ? seconds : usual_s + 0.1 * (seconds - usual_s);
      }
      attachRanges(t, T_O_B);
      travelled.metres += step;
      travelled.radians += logQuat(last.q.conjugate() * T_O_B.q).norm();
      const OdometryOptions& o = config.odometry;
      out.keyframe = jumped || travelled.gap_s > 0 || travelled.metres >= o.node_distance_m ||
                     travelled.radians >= o.node_turn_rad ||
                     toSeconds(t - window.head().t) >= o.node_interval_s;
      if (out.keyframe) advance(t, T_O_B);
    }
    last = T_O_B;
    last_t = t;
    out.state.T_W_B = window.toWorld(T_O_B);
    out.covariance = covarianceInWorld(out.state.T_W_B);
    out.odometry_scale = std::exp(window.head().x[4]);
    out.segment = segment;
    out.valid = true;
    out.health = Health::ok;
  }
  out.ms.optimise = out.ms.total;
  results.push_back(out);
}

OdometryRangeEstimator::OdometryRangeEstimator(const OdometryRangeConfig& config, LogSink log) {
  config.validate();
  impl_ = std::make_unique<Impl>(config, std::move(log));
}
OdometryRangeEstimator::~OdometryRangeEstimator() = default;

void OdometryRangeEstimator::addOdometry(TimeNs t, const Pose& T_O_B) {
  if (!impl_->plausible(t, T_O_B)) return;
  impl_->process(t, {T_O_B.q.normalized(), T_O_B.p});
}

void OdometryRangeEstimator::addRange(const Range& range) {
  if (!impl_->config.ranges.use) return;
  if (isStamp(range.t)) {
    impl_->ranges.offer(range);
  } else {
    ++impl_->bad_stamps;
  }
}

void OdometryRangeEstimator::addAnchorRange(const AnchorRange& range) {
  if (impl_->config.ranges.use) impl_->ranges.offer(range);
}

void OdometryRangeEstimator::anchorDeployed(std::uint64_t id, const Vec3& p_B, double sigma_m) {
  Impl& s = *impl_;
  if (s.window.empty()) {
    s.ranges.putDownUnseen(id);
  } else {
    s.ranges.putDown(id, s.window.toWorld(s.last) * p_B, sigma_m);
  }
  s.collectRangeWarnings();
}

std::vector<StateEstimate> OdometryRangeEstimator::take() {
  return std::exchange(impl_->results, {});
}
std::vector<RangeRecord> OdometryRangeEstimator::takeRanges() { return impl_->ranges.take(); }
std::vector<StampedPose> OdometryRangeEstimator::takeSettled() {
  const std::vector<FollowedPose> settled = impl_->retired.takeSettled();
  return {settled.begin(), settled.end()};
}
std::vector<Anchor> OdometryRangeEstimator::anchors() const { return impl_->ranges.anchors(); }
std::optional<SurveyFit> OdometryRangeEstimator::survey() const { return impl_->ranges.survey(); }

std::vector<StampedPose> OdometryRangeEstimator::keyframes() const {
  std::vector<StampedPose> out = impl_->retired.kept();
  if (impl_->window.empty()) return out;
  for (const window::LongNode& n : impl_->window.nodes()) out.push_back({n.t, n.T_W_B()});
  out.push_back({impl_->window.head().t, impl_->window.head().T_W_B()});
  return out;
}

std::vector<std::pair<std::string, long>> OdometryRangeEstimator::counters() const {
  const Impl& s = *impl_;
  std::vector<std::pair<std::string, long>> out{{"odometry_poses", s.poses}};
  const auto add = [&](const char* name, long n) {
    if (n > 0) out.emplace_back(name, n);
  };
  add("odometry_not_finite", s.not_finite);
  add("bad_stamps", s.bad_stamps);
  add("odometry_out_of_order", s.out_of_order);
  add("odometry_jumps", s.jumps);
  add("odometry_gaps", s.gaps);
  for (const auto& c : s.ranges.counters()) out.push_back(c);
  return out;
}
double OdometryRangeEstimator::odometryScale() const {
  return impl_->window.empty() ? 1 : std::exp(impl_->window.head().x[4]);
}
const std::vector<std::string>& OdometryRangeEstimator::warnings() const { return impl_->warnings; }

}  // namespace vir::estimator
