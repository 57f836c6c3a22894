#include "odometry_chain.h"

#include <optional>

namespace vir::pyfg {
namespace {

using Motion = Numbered<MotionEdge>;

/// What leads to one pose, if anything does.
struct Link {
  const Motion* motion = nullptr;
};

/// Adds a motion's uncertainty to that of the steps before it. Both are of position along the axes
/// of O and rotation on the right; R is the attitude before the motion.
Mat6 grown(const Mat6& before, const Mat3& R, const Pose& motion, const Mat6& covariance) {
  Mat6 F = Mat6::Identity();
  F.block<3, 3>(0, 3) = -R * hat(motion.p);
  F.block<3, 3>(3, 3) = motion.R().transpose();
  Mat6 G = Mat6::Identity();
  G.block<3, 3>(0, 0) = R;
  return F * before * F.transpose() + G * covariance * G.transpose();
}

class Chain {
 public:
  Chain(const Graph& graph, char robot, const PlanarSigmas& planar, ProblemLog* log)
      : graph_(graph), robot_(robot), planar_(planar), log_(log) {}

  std::vector<OdometryPose> integrate() {
    collect();
    const int* previous = nullptr;
    for (const auto& [number, link] : links_) {
      if (previous == nullptr) {
        start(number);
      } else if (link.motion != nullptr && link.motion->item.from.number == *previous) {
        follow(*link.motion);
      } else {
        if (link.motion != nullptr) log_->count("motions_not_odometry");
        gap(*previous, number);
      }
      previous = &number;
    }
    return std::move(path_);
  }

 private:
  void collect() {
    for (const auto& [v, line] : graph_.vertices) {
      if (v.name.letter == robot_) stamps_[v.name.number] = v.t;
    }
    for (const Motion& m : graph_.motions) {
      const Name &from = m.item.from, &to = m.item.to;
      if (from.letter != robot_ || to.letter != robot_) continue;
      for (const Name& n : {from, to}) {
        if (!stamps_.empty() && stamps_.count(n.number) == 0) {
          log_->add("odometry_unknown_vertex", graph_.where(m.line),
                    "there is no vertex " + toString(n) + "; the motion is used all the same");
        }
      }
      if (to.number <= from.number) continue;
      links_[from.number];
      Link& link = links_[to.number];
      if (link.motion == nullptr || link.motion->item.from.number < from.number) link.motion = &m;
    }
    countUnused();
  }

  void countUnused() {
    for (const Motion& m : graph_.motions) {
      const Name &from = m.item.from, &to = m.item.to;
      if (from.letter != robot_ && to.letter != robot_) continue;
      if (from.letter == to.letter && to.number > from.number && links_[to.number].motion == &m) {
        continue;
      }
      log_->count("motions_not_odometry");
      log_->note(
          "motions between poses that do not follow each other (loop closures) are counted "
          "as motions_not_odometry and not used");
    }
  }

  void start(int number) {
    const auto stamp = stamps_.find(number);
    if (stamp != stamps_.end()) {
      give(stamp->second);
    } else {
      log_->note("the first pose of the odometry, " + toString({robot_, number}) +
                 ", has no stamp: the path begins with the next one");
    }
  }

  void follow(const Motion& m) {
    Mat6 covariance = m.item.covariance;
    if (m.item.planar && m.item.covariance_usable) {
      covariance(2, 2) = planar_.z_m * planar_.z_m;
      covariance(3, 3) = covariance(4, 4) = planar_.tilt_rad * planar_.tilt_rad;
    }
    advance(m.item.T_from_to, covariance);
    if (!give(m.item.t)) {
      log_->add("odometry_time_not_growing", graph_.where(m.line),
                "the motion to " + toString(m.item.to) +
                    " is not later than the one before; its pose is left out, its motion is not");
    }
  }

  void gap(int before, int number) {
    const Name a{robot_, before}, b{robot_, number};
    log_->add("odometry_gaps", graph_.path,
              "no motion leads from " + toString(a) + " to " + toString(b) +
                  ": what the robot did between them is not known");
    Mat6 covariance = Mat6::Zero();
    covariance.diagonal().head<3>().setConstant(kUnknownPositionVariance);
    covariance.diagonal().tail<3>().setConstant(kUnknownRotationVariance);
    advance(Pose(), covariance);
    const auto stamp = stamps_.find(number);
    if (stamp != stamps_.end()) give(stamp->second);
  }

  void advance(const Pose& motion, const Mat6& covariance) {
    step_ = grown(step_, T_O_B_.R(), motion, covariance);
    T_O_B_ = T_O_B_ * motion;
  }

  /// False if the stamp does not grow.
  bool give(TimeNs t) {
    if (!path_.empty() && t <= path_.back().t) return false;
    path_.push_back({t, T_O_B_, path_.empty() ? Mat6(Mat6::Zero()) : step_});
    step_.setZero();
    return true;
  }

  const Graph& graph_;
  const char robot_;
  const PlanarSigmas planar_;
  ProblemLog* log_;
  std::map<int, TimeNs> stamps_;  // of the vertices
  std::map<int, Link> links_;     // of the poses that motions name
  Pose T_O_B_;
  Mat6 step_ = Mat6::Zero();
  std::vector<OdometryPose> path_;
};

}  // namespace

std::vector<OdometryPose> integrateOdometry(const Graph& graph, char robot,
                                            const PlanarSigmas& planar, ProblemLog* log) {
  return Chain(graph, robot, planar, log).integrate();
}

}  // namespace vir::pyfg
