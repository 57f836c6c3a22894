#pragma once
/// Flies a simulated odometry with ranges through OdometryRangeEstimator.
#include <Eigen/Dense>
#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "vir/estimator/odometry_range_estimator.h"
#include "vir/evaluation/evaluate.h"
#include "vir/simulation/flights.h"
#include "vir/simulation/simulate_odometry.h"
#include "vir/simulation/simulate_ranges.h"

namespace vir_test {

using vir::Anchor;
using vir::Pose;
using vir::Range;
using vir::RangeDecision;
using vir::RangeRecord;
using vir::StateEstimate;
using vir::TimeNs;
using vir::Vec3;

/// A flight with everything that is measured on it. W is the odometry's frame at the start.
struct RangeWorld {
  explicit RangeWorld(vir::simulation::Motion m,
                      const vir::simulation::OdometrySimulationOptions& o,
                      const vir::simulation::RangeSimulationOptions& r)
      : motion(std::move(m)), range_options(r) {
    odometry = vir::simulation::simulateOdometry(motion, o);
    for (const vir::simulation::SimulatedRange& s : vir::simulation::simulateRanges(motion, r)) {
      ranges.push_back(measurement(s));
    }
    const Pose first = motion.poseAt(motion.begin());
    T_W_M = Pose(vir::Quat(vir::rotZ(-vir::yawOf(first.R()))), Vec3::Zero());
    T_W_M.p = -(T_W_M.q * first.p);
  }
  Range measurement(const vir::simulation::SimulatedRange& s) const {
    Range r;
    r.t = s.t;
    r.anchor = static_cast<std::uint64_t>(s.anchor);
    r.range_m = s.range_m;
    r.sigma_m = range_options.sigma_m;
    r.p_B_U = Vec3(range_options.lever_arm_m.data());
    return r;
  }
  /// Where the body truly is, in W.
  Pose truth(TimeNs t) const { return T_W_M * motion.poseAt(t); }
  Vec3 anchor(std::size_t index, double s = 0) const {
    return T_W_M * vir::simulation::anchorAt(range_options, index, s);
  }
  /// When the body has been under way for `s` seconds.
  TimeNs time(double s) const { return motion.begin() + vir::fromSeconds(s); }

  vir::simulation::Motion motion;
  vir::simulation::RangeSimulationOptions range_options;
  vir::Trajectory odometry;
  std::vector<Range> ranges;
  Pose T_W_M;  ///< from the frame of the motion
};

struct RangeRun {
  std::vector<StateEstimate> estimates;
  std::vector<Anchor> anchors;
  std::vector<vir::RangeRecord> decisions;
  std::vector<std::pair<std::string, long>> counters;
  std::vector<std::string> warnings;
  std::optional<vir::SurveyFit> survey;

  long count(RangeDecision decision) const {
    long n = 0;
    for (const RangeRecord& d : decisions) n += d.decision == decision;
    return n;
  }
  long count(const std::string& name) const {
    for (const auto& [n, value] : counters) {
      if (n == name) return value;
    }
    return 0;
  }
  const Anchor* anchor(std::uint64_t id) const {
    for (const Anchor& a : anchors) {
      if (a.id == id) return &a;
    }
    return nullptr;
  }
  bool warned(const std::string& word) const {
    return std::any_of(warnings.begin(), warnings.end(),
                       [&](const std::string& w) { return w.find(word) != std::string::npos; });
  }
};

/// Called after every pose.
using AtPose =
    std::function<void(const vir::estimator::OdometryRangeEstimator&, const StateEstimate&)>;

/// Ranges in the order of the list, each before the first pose that is not older than it.
inline RangeRun fly(const RangeWorld& world, const vir::estimator::OdometryRangeConfig& config,
                    const std::vector<Range>& ranges, const AtPose& at_pose = {}) {
  vir::estimator::OdometryRangeEstimator estimator(config);
  RangeRun out;
  std::size_t next = 0;
  for (const vir::StampedPose& p : world.odometry) {
    for (; next < ranges.size() && !(ranges[next].t > p.t); ++next) {
      estimator.addRange(ranges[next]);
    }
    estimator.addOdometry(p.t, p.T_W_B);
    for (const StateEstimate& e : estimator.take()) {
      out.estimates.push_back(e);
      if (at_pose) at_pose(estimator, e);
    }
  }
  out.anchors = estimator.anchors();
  out.decisions = estimator.takeRanges();
  out.counters = estimator.counters();
  out.warnings = estimator.warnings();
  out.survey = estimator.survey();
  return out;
}

inline RangeRun fly(const RangeWorld& world, const vir::estimator::OdometryRangeConfig& config = {},
                    const AtPose& at_pose = {}) {
  return fly(world, config, world.ranges, at_pose);
}

/// ATE (position and yaw aligned) of the causal trajectory [m].
inline double ate(const RangeWorld& world, const RangeRun& run) {
  vir::Trajectory estimate;
  for (const StateEstimate& e : run.estimates) estimate.push_back({e.state.t, e.state.T_W_B});
  return vir::evaluation::evaluate(world.motion.sampled(50), estimate, {}).ate_position_m.rmse;
}

inline vir::simulation::FlightOptions flightOf(double length_m, int seed = 1) {
  vir::simulation::FlightOptions o;
  o.length_m = length_m;
  o.seed = seed;
  return o;
}

/// An odometry that drifts as the defaults of OdometryOptions say, or less.
inline vir::simulation::OdometrySimulationOptions drifting(int seed = 1) {
  vir::simulation::OdometrySimulationOptions o;
  o.scale_error = 0.05;
  o.yaw_walk = 0.01;
  o.position_walk = 0.02;
  o.seed = seed;
  return o;
}

inline vir::simulation::RangeSimulationOptions rangesTo(const std::vector<Vec3>& anchors,
                                                        int seed = 1) {
  vir::simulation::RangeSimulationOptions o;
  o.rate_hz = 10;
  o.seed = seed;
  for (const Vec3& a : anchors) o.anchor_m.insert(o.anchor_m.end(), {a.x(), a.y(), a.z()});
  o.lever_arm_m = {0.05, 0, 0.1};
  return o;
}

}  // namespace vir_test
