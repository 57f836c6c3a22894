#pragma once
/// A walk with an odometry whose heading and scale drift, ranges to anchors, and the dense batch
/// solution that the long window's elimination must agree with.
#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include "vir/factors/node_edge_factor.h"
#include "vir/factors/node_range_difference_factor.h"
#include "vir/factors/node_range_factor.h"
#include "vir/factors/position_link_factor.h"
#include "vir/window/long_window.h"
#include "vir_test_jacobian.h"
#include "vir_test_noise.h"

namespace vir_test {

using vir::Pose;
using vir::Vec3;
using vir::window::HeldRange;
using vir::window::LongWindow;

struct WalkOptions {
  int nodes = 60;
  std::vector<Vec3> anchors{{8, 5, 3}};
  double yaw_drift = 0.004;  ///< of O in W, per node [rad]
  double log_scale = 0;
  double position_noise_m = 0.003, yaw_noise_rad = 0.0005;  ///< per node
  double range_noise_m = 0.03;
  int ranges_per_node = 2;   ///< to each anchor
  bool differences = false;  ///< of the ranges to each anchor and the one before it
  double height_m = 1.0;
  unsigned seed = 1;
};

/// A figure eight of 12 by 6 m that goes up and down; about 0.7 m from node to node.
struct Walk {
  explicit Walk(const WalkOptions& o) : options(o) {
    vir::test::Noise noise(o.seed);
    const auto place = [&](int k) {
      const double a = 2 * M_PI * k / 50;
      return Vec3(6 * std::sin(a), 3 * std::sin(2 * a), o.height_m * std::sin(0.37 * a));
    };
    double yaw = 0;
    Vec3 p_O = place(0);
    for (int k = 0; k < o.nodes; ++k) {
      const vir::Quat q_W = vir::Quat(vir::rotZ(0.3 * k)) * vir::expQuat(Vec3(0.1, 0.05, 0));
      const vir::Mat3 R_O_W = vir::rotZ(-yaw);
      truth.emplace_back(q_W, place(k));
      odometry.emplace_back((vir::Quat(R_O_W) * q_W).normalized(), p_O);
      yaw_of_O.push_back(yaw);
      const Vec3 step_O = std::exp(o.log_scale) * (R_O_W * (place(k + 1) - place(k)));
      std::vector<HeldRange> here;
      for (int j = 0; j < o.ranges_per_node; ++j) {
        const double u = j / static_cast<double>(o.ranges_per_node);
        for (std::size_t a = 0; a < o.anchors.size(); ++a) {
          HeldRange r;
          r.t = 1000000000LL * k + static_cast<vir::TimeNs>(1e9 * u);
          r.anchor = a;
          r.motion = u * step_O;
          r.lever = R_O_W * (q_W * Vec3(0.1, -0.05, 0.2));
          const Vec3 p_U =
              place(k) + vir::rotZ(yaw) * (std::exp(-o.log_scale) * r.motion + r.lever);
          r.sigma_m = std::max(o.range_noise_m, 0.01);
          r.range_m = (p_U - o.anchors[a]).norm() + o.range_noise_m * noise.normal();
          if (o.differences) {
            r.reference = (a + o.anchors.size() - 1) % o.anchors.size();
            r.range_m -= (p_U - o.anchors[*r.reference]).norm();
          }
          here.push_back(r);
        }
      }
      ranges.push_back(here);
      Vec3 error;
      for (int i = 0; i < 3; ++i) error[i] = o.position_noise_m * noise.normal();
      p_O += step_O + error;
      yaw += o.yaw_drift + o.yaw_noise_rad * noise.normal();
    }
  }

  static Eigen::Matrix4d covariance() {
    return Eigen::Vector4d(4e-4, 4e-4, 4e-4, 1e-4).asDiagonal();
  }

  void addAnchors(LongWindow* w, double offset_m, double sigma_m) const {
    for (std::size_t a = 0; a < options.anchors.size(); ++a) {
      Eigen::Vector4d mean;
      mean << options.anchors[a] + offset_m * Vec3(0.6, -0.7, 0.4), 0;
      const double s = sigma_m * sigma_m;
      w->addAnchor(a, mean, Eigen::Vector4d(s, s, s, 1e-4).asDiagonal());
    }
  }
  void start(LongWindow* w) const { w->start(0, odometry[0], truth[0], 0.001, 0.001); }
  /// Node k - 1 gets its ranges and is followed by node k.
  void advance(LongWindow* w, std::size_t k) const {
    w->advance(1000000000LL * static_cast<vir::TimeNs>(k), odometry[k], ranges[k - 1],
               covariance());
  }
  const std::vector<HeldRange>& lastRanges() const { return ranges.back(); }

  WalkOptions options;
  std::vector<Pose> truth, odometry;
  std::vector<double> yaw_of_O;
  std::vector<std::vector<HeldRange>> ranges;
};

/// Everything a window holds whose nodes have never been marginalised, as one dense problem.
class Batch {
 public:
  Batch(LongWindow* w, const std::vector<HeldRange>& head_ranges, const Pose& start)
      : frozen_(w->frozen()) {
    const auto add = [&](const double* v, int n) { x.emplace_back(v, v + n); };
    for (const vir::window::LongNode& n : w->nodes()) add(n.x, 5);
    add(w->head().x, 5);
    nodes_ = static_cast<int>(x.size());
    std::map<std::uint64_t, int> index;
    for (const auto& [id, a] : w->anchors()) {
      index[id] = static_cast<int>(x.size());
      add(a.x, 4);
      anchor_mean_.push_back(a.prior_mean);
      anchor_information_.push_back(a.prior_information);
    }
    first_ << start.p, 0, 0;
    const double scale = w->options().scale_sigma > 0 ? w->options().scale_sigma : 1;
    information_ << 1e6, 1e6, 1e6, 1e6, 1 / (scale * scale);
    const auto hold = [&](const std::vector<HeldRange>& list, int k) {
      for (const HeldRange& r : list) {
        const vir::factors::RangeTerm term = w->termOf(r.anchor, r.range_m, r.sigma_m);
        if (r.reference) {
          put(std::make_unique<vir::factors::NodeRangeDifferenceFactor>(term, r.motion, r.lever),
              {k, index.at(*r.reference), index.at(r.anchor)});
          continue;
        }
        put(std::make_unique<vir::factors::NodeRangeFactor>(term, r.motion, r.lever),
            {k, index.at(r.anchor)});
      }
    };
    for (int k = 0; k + 1 < nodes_; ++k) {
      const vir::window::LongNode& n = w->nodes()[static_cast<std::size_t>(k)];
      hold(n.ranges, k);
      if (w->options().mode == vir::window::LongWindowMode::position) {
        for (std::size_t j = 0; j < n.links.size(); ++j) {
          put(std::make_unique<vir::factors::PositionLinkFactor>(n.links[j].z_W, n.links[j].gamma),
              {k, k + 1 + static_cast<int>(j)});
        }
      } else {
        put(std::make_unique<vir::factors::NodeEdgeFactor>(n.motion_O, n.sqrt_information,
                                                           n.sigma_log_scale),
            {k, k + 1});
      }
    }
    hold(head_ranges, nodes_ - 1);
  }

  int offsetOf(int block) const {
    return block <= nodes_ ? 5 * block : 5 * nodes_ + 4 * (block - nodes_);
  }

  Eigen::VectorXd step() {
    const int n = offsetOf(static_cast<int>(x.size()));
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
    for (const Term& t : terms_) {
      Blocks at;
      for (const int block : t.blocks) at.push_back(x[static_cast<std::size_t>(block)]);
      Eigen::VectorXd r;
      const auto J = analyticJacobians(*t.cost, at, &r);
      Eigen::MatrixXd row = Eigen::MatrixXd::Zero(r.size(), n);
      for (std::size_t i = 0; i < J.size(); ++i) {
        row.middleCols(offsetOf(t.blocks[i]), J[i].cols()) = J[i];
      }
      H += row.transpose() * row;
      b += row.transpose() * r;
    }
    const Eigen::Matrix<double, 5, 1> d = Eigen::Matrix<double, 5, 1>(x[0].data()) - first_;
    H.topLeftCorner<5, 5>() += information_.asDiagonal();
    b.head<5>() += information_.cwiseProduct(d);
    for (std::size_t a = 0; a < anchor_mean_.size(); ++a) {
      const int at = offsetOf(nodes_ + static_cast<int>(a));
      const Eigen::Vector4d now(x[static_cast<std::size_t>(nodes_) + a].data());
      H.block<4, 4>(at, at) += anchor_information_[a];
      b.segment<4>(at) += anchor_information_[a] * (now - anchor_mean_[a]);
    }
    for (int k = 0; k < nodes_; ++k) {
      for (int i : frozen_) {
        H.row(5 * k + i).setZero();
        H.col(5 * k + i).setZero();
        H(5 * k + i, 5 * k + i) = 1;
        b[5 * k + i] = 0;
      }
    }
    covariance = H.inverse();
    return -H.ldlt().solve(b);
  }
  void apply(const Eigen::VectorXd& d) {
    int c = 0;
    for (std::vector<double>& block : x) {
      for (double& v : block) v += d[c++];
    }
  }
  void solve(int iterations) {
    for (int k = 0; k < iterations; ++k) apply(step());
  }
  int nodes() const { return nodes_; }

  Blocks x;  ///< nodes, head, anchors
  Eigen::MatrixXd covariance;

 private:
  struct Term {
    std::unique_ptr<ceres::CostFunction> cost;
    std::vector<int> blocks;
  };
  void put(std::unique_ptr<ceres::CostFunction> cost, std::vector<int> blocks) {
    terms_.push_back({std::move(cost), std::move(blocks)});
  }

  std::vector<int> frozen_;
  int nodes_ = 0;
  std::vector<Term> terms_;
  Eigen::Matrix<double, 5, 1> first_, information_;
  std::vector<Eigen::Vector4d> anchor_mean_;
  std::vector<Eigen::Matrix4d> anchor_information_;
};

/// All present values of a window in the order of `Batch::x`.
inline Blocks valuesOf(const LongWindow& w) {
  Blocks out;
  for (const vir::window::LongNode& n : w.nodes()) out.emplace_back(n.x, n.x + 5);
  out.emplace_back(w.head().x, w.head().x + 5);
  for (const auto& [id, a] : w.anchors()) out.emplace_back(a.x, a.x + 4);
  return out;
}

inline double largestDifference(const Blocks& a, const Blocks& b) {
  EXPECT_EQ(a.size(), b.size());
  double worst = 0;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    for (std::size_t i = 0; i < a[k].size(); ++i) {
      worst = std::max(worst, std::abs(a[k][i] - b[k][i]));
    }
  }
  return worst;
}

}  // namespace vir_test
