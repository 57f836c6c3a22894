#include "vir/simulation/simulate_team_ranges.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "range_channel.h"
#include "vir/simulation/interval.h"
#include "vir/types/interpolation.h"

namespace vir::simulation {
namespace {

/// What one robot believes and tells.
class Teller {
 public:
  Teller(const TeamRobot& robot, const RangeSimulationOptions& ranges, const TeamRangeOptions& team,
         OdometrySimulationOptions odometry, int number)
      : ranges_(ranges), team_(team), begin_(robot.motion->begin()) {
    odometry.seed += number;
    odometry_ = odometry;
    poses_ = simulateOdometry(*robot.motion, odometry);
    const Pose first = robot.motion->poseAt(begin_);
    T_W_O_ = {Quat(rotZ(yawOf(first.R()))), first.p};
    Random random(static_cast<std::uint64_t>(odometry.seed), 320);
    for (std::size_t a = 0; 3 * a < ranges.anchor_m.size(); ++a) {
      const double x = random.normal(), y = random.normal(), z = random.normal();
      anchor_errors_.push_back(team.anchor_sigma_m * Vec3(x, y, z));
    }
  }

  const Pose& T_W_O() const { return T_W_O_; }

  std::vector<ToldPosition> tell(TimeNs t, const Vec3& lever) const {
    std::vector<ToldPosition> out;
    const double s = toSeconds(t - begin_);
    const Pose T_O_B = heldPoseAt(poses_, t);
    out.push_back({-1, T_O_B * lever, covarianceAt(s, T_O_B.p)});
    if (s < team_.anchor_known_s) return out;
    for (std::size_t a = 0; a < anchor_errors_.size(); ++a) {
      ToldPosition p;
      p.anchor = anchorId(ranges_, a);
      p.p_O = T_W_O_.inverse() * anchorAt(ranges_, a, s) + anchor_errors_[a];
      p.covariance = std::pow(std::max(team_.anchor_sigma_m, 0.01), 2) * Mat3::Identity();
      out.push_back(p);
    }
    return out;
  }

 private:
  /// To first order: the errors of simulateOdometry grow like this.
  Mat3 covarianceAt(double s, const Vec3& p_O) const {
    const OdometrySimulationOptions& o = odometry_;
    const double walk =
        o.position_noise_m * o.position_noise_m + o.position_walk * o.position_walk * s + 1e-4;
    const double along = o.scale_error * o.scale_error + o.scale_wander * o.scale_wander;
    const double yaw = std::pow(o.yaw_drift_radps * s, 2) + o.yaw_walk * o.yaw_walk * s;
    const Vec3 across = Vec3::UnitZ().cross(p_O);
    return walk * Mat3::Identity() + along * p_O * p_O.transpose() +
           yaw * across * across.transpose();
  }

  const RangeSimulationOptions& ranges_;
  const TeamRangeOptions& team_;
  OdometrySimulationOptions odometry_;
  TimeNs begin_;
  Trajectory poses_;
  Pose T_W_O_;
  std::vector<Vec3> anchor_errors_;
};

/// Two that range: robots by index, or a robot and an anchor.
struct Link {
  std::size_t first = 0;
  bool to_robot = false;
  std::size_t second = 0;
  double rate_hz = 0;
  int every = 1;  ///< periods
};

std::vector<Link> linksOf(std::size_t robots, const RangeSimulationOptions& o,
                          const TeamRangeOptions& team) {
  std::vector<Link> links;
  const std::size_t anchors = o.anchor_m.size() / 3;
  for (std::size_t r = 0; r < robots; ++r) {
    for (std::size_t a = 0; a < anchors; ++a) links.push_back({r, false, a, o.rate_hz, 1});
  }
  for (std::size_t r = 0; team.peer_rate_hz > 0 && r < robots; ++r) {
    for (std::size_t q = r + 1; q < robots; ++q) {
      links.push_back({r, true, q, team.peer_rate_hz, 1});
    }
  }
  double fastest = 0;
  for (const Link& l : links) fastest = std::max(fastest, l.rate_hz);
  for (Link& l : links) l.every = std::max(1, static_cast<int>(std::lround(fastest / l.rate_hz)));
  return links;
}

void checkRobots(const std::vector<TeamRobot>& robots) {
  std::set<int> ids;
  for (const TeamRobot& r : robots) {
    if (!r.motion) throw std::invalid_argument("simulateTeamRanges: a robot without a motion");
    if (!ids.insert(r.id).second) {
      throw std::invalid_argument("simulateTeamRanges: robot " + std::to_string(r.id) +
                                  " occurs twice");
    }
  }
}

/// All of one link.
class LinkRun {
 public:
  LinkRun(const std::vector<TeamRobot>& robots, const std::vector<Teller>& tellers,
          const RangeSimulationOptions& o, const rendering::Scene* scene)
      : robots_(robots), tellers_(tellers), o_(o), scene_(scene) {
    lever_ = Vec3(o.lever_arm_m[0], o.lever_arm_m[1], o.lever_arm_m[2]);
  }

  void run(const Link& link, std::size_t number, std::size_t links, double period,
           std::vector<RobotRanges>* out) const {
    RangeChannel channel(o_, 2000 + number, scene_);
    const Motion& motion = *robots_[link.first].motion;
    const double slot = period / static_cast<double>(links);
    double last = 0;
    // The turns of slower links are spread over the periods.
    for (int k = static_cast<int>(number) % link.every;; k += link.every) {
      const double s = k * period + slot * (static_cast<double>(number) + 0.5 + channel.jitter());
      const TimeNs t = motion.begin() + fromSeconds(s);
      if (t > motion.end()) return;
      if (link.to_robot &&
          (t < robots_[link.second].motion->begin() || t > robots_[link.second].motion->end())) {
        continue;
      }
      SimulatedRange r = channel.measure(motion.poseAt(t) * lever_, otherEnd(link, t, s), s - last);
      last = s;
      r.t = t;
      if (!channel.lost() && !insideAny(o_.outage_s, s)) keep(link, r, out);
    }
  }

 private:
  Vec3 otherEnd(const Link& link, TimeNs t, double s) const {
    if (!link.to_robot) return anchorAt(o_, link.second, s);
    return robots_[link.second].motion->poseAt(t) * lever_;
  }

  void keep(const Link& link, SimulatedRange r, std::vector<RobotRanges>* out) const {
    if (!link.to_robot) {
      r.anchor = anchorId(o_, link.second);
      (*out)[link.first].anchors.push_back(r);
      return;
    }
    for (const auto& [self, other] :
         {std::pair(link.first, link.second), std::pair(link.second, link.first)}) {
      r.anchor = robots_[other].id;
      (*out)[self].peers.push_back({r, tellers_[other].tell(r.t, lever_)});
    }
  }

  const std::vector<TeamRobot>& robots_;
  const std::vector<Teller>& tellers_;
  const RangeSimulationOptions& o_;
  const rendering::Scene* scene_;
  Vec3 lever_;
};

}  // namespace

std::vector<RobotRanges> simulateTeamRanges(const std::vector<TeamRobot>& robots,
                                            const RangeSimulationOptions& o,
                                            const TeamRangeOptions& team,
                                            const OdometrySimulationOptions& odometry,
                                            const rendering::Scene* scene) {
  checkRangeOptions(o);
  checkRobots(robots);
  std::vector<Teller> tellers;
  for (std::size_t r = 0; r < robots.size(); ++r) {
    tellers.emplace_back(robots[r], o, team, odometry, static_cast<int>(r));
  }
  std::vector<RobotRanges> out(robots.size());
  for (std::size_t r = 0; r < robots.size(); ++r) out[r].T_W_O = tellers[r].T_W_O();
  const std::vector<Link> links = linksOf(robots.size(), o, team);
  double fastest = 0;
  for (const Link& l : links) fastest = std::max(fastest, l.rate_hz);
  const LinkRun runner(robots, tellers, o, scene);
  for (std::size_t k = 0; k < links.size(); ++k) {
    runner.run(links[k], k, links.size(), 1 / fastest, &out);
  }
  for (RobotRanges& r : out) {
    std::stable_sort(r.anchors.begin(), r.anchors.end(),
                     [](const SimulatedRange& x, const SimulatedRange& y) { return x.t < y.t; });
    std::stable_sort(r.peers.begin(), r.peers.end(),
                     [](const PeerRange& x, const PeerRange& y) { return x.range.t < y.range.t; });
  }
  return out;
}

}  // namespace vir::simulation
