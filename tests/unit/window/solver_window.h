#pragma once
/// A window as the estimator makes it, all of it in the open, for the solver and for Ceres.
#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "minimiser.h"
#include "vir/factors/head_range_factor.h"
#include "vir/factors/imu_factor.h"
#include "vir/factors/linear_prior_factor.h"
#include "vir/factors/pose_manifold.h"
#include "vir/factors/reprojection_factor.h"
#include "vir/factors/window_range_factor.h"
#include "vir_test_scene.h"

namespace vir_test {

using vir::Pose;

struct WindowVariant {
  bool calibrated = true;
  bool cauchy = true;
  bool ranges = true;
  double disturb = 0.02;
};

/// A few frames, landmarks, inertial links, a prior, and ranges to one anchor.
class SolverWindow {
 public:
  static constexpr int kFrames = 6;
  static constexpr double kSigmaPx = 0.3;

  explicit SolverWindow(const WindowVariant& v) : variant_(v), scene_(vir_test::circling, 5) {
    scene_.noise_px = kSigmaPx;
    vir::factors::poseTo(Scene::T_B_C(), extrinsic_.data());
    addFrames();
    addLandmarks();
    addPrior();
    if (v.ranges) addRanges();
    build();
  }

  vir::window::LeastSquares problem() {
    vir::window::LeastSquares out;
    for (int k = kFrames; k-- > 0;) out.order.push_back({frame(k).speed_bias.data(), 9});
    out.leading = kFrames;
    for (Frame& f : frames_) out.order.push_back({f.pose.data(), 7});
    if (variant_.calibrated) {
      // The lens is held.
      const int camera = 15 * kFrames + 6;
      out.held = {camera + vir::factors::kRadial1, camera + vir::factors::kRadial2};
      out.order.push_back({extrinsic_.data(), 7});
      out.order.push_back({camera_.data(), vir::factors::kCameraParameters});
      out.order.push_back({imu_.data(), vir::imu::kImuIntrinsicsSize});
    }
    out.terms = &terms_;
    if (!variant_.ranges) return out;
    out.order.push_back({node_.data(), 5});
    out.order.push_back({anchor_.data(), 4});
    out.further = &range_terms_;
    return out;
  }

  double solveByCeres(int iterations) {
    ceres::Problem::Options problem_options;
    problem_options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(problem_options);
    vir::factors::PoseManifold pose;
    ceres::SubsetManifold camera(vir::factors::kCameraParameters,
                                 {vir::factors::kRadial1, vir::factors::kRadial2});
    const ceres::CauchyLoss cauchy(1.0);
    const ceres::HuberLoss huber(1.0);
    const ceres::LossFunction* loss = &huber;
    if (variant_.cauchy) loss = &cauchy;
    for (const std::vector<vir::window::Term>* list : {&terms_, &range_terms_}) {
      for (const vir::window::Term& t : *list) {
        problem.AddResidualBlock(const_cast<ceres::CostFunction*>(t.cost),
                                 t.robust > 0 ? const_cast<ceres::LossFunction*>(loss) : nullptr,
                                 std::vector<double*>(t.blocks.begin(), t.blocks.end()));
      }
    }
    for (Frame& f : frames_) problem.SetManifold(f.pose.data(), &pose);
    if (variant_.calibrated) {
      problem.SetManifold(extrinsic_.data(), &pose);
      problem.SetManifold(camera_.data(), &camera);
    }
    ceres::Solver::Options options;
    options.max_num_iterations = iterations;
    options.function_tolerance = 1e-5;
    options.initial_trust_region_radius = 1e8;
    options.linear_solver_type = ceres::DENSE_QR;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    ceres_iterations = static_cast<int>(summary.iterations.size());
    return summary.final_cost;
  }

  std::vector<double> values() {
    std::vector<double> out;
    for (auto& [x, size] : blocks()) out.insert(out.end(), x, x + size);
    return out;
  }
  void setValues(const std::vector<double>& v) {
    const double* from = v.data();
    for (auto& [x, size] : blocks()) {
      std::copy(from, from + size, x);
      from += size;
    }
  }
  /// H and b of the terms of camera and IMU in the order of problem(), landmarks behind.
  void dense(Eigen::MatrixXd* H, Eigen::VectorXd* b) {
    std::map<const double*, std::pair<int, int>> column;
    int n = 0;
    for (const vir::window::BlockRef& r : problem().order) {
      if (r.data == node_.data() || r.data == anchor_.data()) continue;
      column[r.data] = {n, r.local()};
      n += r.local();
    }
    for (Point& p : points_) {
      column[p.x.data()] = {n, 3};
      n += 3;
    }
    *H = Eigen::MatrixXd::Zero(n, n);
    *b = Eigen::VectorXd::Zero(n);
    for (const vir::window::Term& t : terms_) {
      const auto rows = t.cost->num_residuals();
      Eigen::VectorXd r(rows);
      std::vector<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>> J;
      std::vector<double*> at;
      for (const int size : t.cost->parameter_block_sizes()) J.emplace_back(rows, size);
      for (auto& j : J) at.push_back(j.data());
      ASSERT_TRUE(t.cost->Evaluate(t.blocks.data(), r.data(), at.data()));
      Eigen::MatrixXd row = Eigen::MatrixXd::Zero(rows, n);
      for (std::size_t k = 0; k < J.size(); ++k) {
        const auto [c, size] = column.at(t.blocks[k]);
        row.middleCols(c, size) = J[k].leftCols(size);
      }
      const double squares = r.squaredNorm(), w = t.robust > 0 ? 1 / (1 + squares) : 1;
      ASSERT_TRUE(t.robust <= 0 || t.cauchy);
      *H += w * row.transpose() * row;
      *b += w * row.transpose() * r;
    }
  }

  int ceres_iterations = 0;

 private:
  struct Frame {
    std::array<double, 7> pose;
    std::array<double, 9> speed_bias{};
    std::array<double, 7> lin;  ///< where Jacobians are taken, of the first ones
    std::unique_ptr<vir::imu::Preintegration> link;
    std::vector<vir::vision::FeatureObservation> seen;
  };
  struct Point {
    std::array<double, 3> x{};
    vir::factors::HostRay ray;
    std::vector<std::pair<int, vir::factors::Sight>> sights;
  };

  Frame& frame(int k) { return frames_[static_cast<std::size_t>(k)]; }

  std::vector<std::pair<double*, int>> blocks() {
    std::vector<std::pair<double*, int>> out;
    for (Frame& f : frames_) {
      out.emplace_back(f.pose.data(), 7);
      out.emplace_back(f.speed_bias.data(), 9);
    }
    out.emplace_back(extrinsic_.data(), 7);
    out.emplace_back(camera_.data(), vir::factors::kCameraParameters);
    out.emplace_back(imu_.data(), vir::imu::kImuIntrinsicsSize);
    out.emplace_back(node_.data(), 5);
    out.emplace_back(anchor_.data(), 4);
    for (Point& p : points_) out.emplace_back(p.x.data(), 3);
    return out;
  }

  void addFrames() {
    vir::imu::ImuBuffer buffer;
    vir::imu::ImuNoise noise;
    noise.noise_scale = 1;
    for (int k = 0; k <= 60 * kFrames; ++k) buffer.add(scene_.imu(vir::fromSeconds(1 + 0.005 * k)));
    for (int k = 0; k < kFrames; ++k) {
      const TimeNs t = vir::fromSeconds(1 + 0.25 * k);
      frames_.emplace_back();
      Frame& f = frames_.back();
      const vir::State s = scene_.truth(t);
      f.seen = scene_.observe(t);
      Pose T = s.T_W_B;
      T.p += scene_.normal3(variant_.disturb);
      T.q = (T.q * vir::expQuat(scene_.normal3(0.3 * variant_.disturb))).normalized();
      vir::factors::poseTo(T, f.pose.data());
      vir::factors::poseTo({T.q * vir::expQuat(scene_.normal3(1e-3)), T.p}, f.lin.data());
      const Vec3 v = s.v + scene_.normal3(variant_.disturb);
      std::copy(v.data(), v.data() + 3, f.speed_bias.data());
      if (k == 0) continue;
      f.link = std::make_unique<vir::imu::Preintegration>(buffer.integrate(
          vir::fromSeconds(1 + 0.25 * (k - 1)), t, noise, Vec3::Zero(), Vec3::Zero()));
    }
  }

  static vir::factors::Sight sightOf(const vir::vision::FeatureObservation& o) {
    vir::factors::Sight s;
    s.bearing = o.bearing;
    s.weight = o.dpx_dbearing / kSigmaPx;
    const Vec2 centre(Scene::kWidth / 2, Scene::kHeight / 2);
    s.by_camera = vir::factors::bearingByCamera(o.px, o.dpx_dbearing, o.bearing_rate, centre,
                                                o.px.y() / Scene::kHeight - 0.5, Vec2(0.1, 0.02));
    return s;
  }

  void addLandmarks() {
    std::map<std::uint64_t, Point> by_id;
    for (int k = 0; k < kFrames; ++k) {
      for (const vir::vision::FeatureObservation& o : frame(k).seen) {
        by_id[o.id].sights.emplace_back(k, sightOf(o));
      }
    }
    int count = 0;
    for (auto& [id, p] : by_id) {
      if (p.sights.size() < 2) continue;
      const auto& [host, sight] = p.sights.front();
      static_cast<vir::factors::CameraRay&>(p.ray) = sight;
      p.ray.basis = vir::factors::tangentBasis(p.ray.bearing);
      const Pose T_W_C = scene_.truth(vir::fromSeconds(1 + 0.25 * host)).T_W_B * Scene::T_B_C();
      p.x[2] = 1 / (T_W_C.inverse() * scene_.point(id)).norm() + 0.05 * variant_.disturb;
      // One in ten is a wrong match.
      if (++count % 10 == 0) p.sights.back().second.bearing += Vec3(0.02, -0.01, 0);
      points_.push_back(p);
    }
  }

  void addPrior() {
    prior_.blocks = {{7, 0, {frame(0).pose.begin(), frame(0).pose.end()}},
                     {9, 6, {frame(0).speed_bias.begin(), frame(0).speed_bias.end()}}};
    prior_blocks_ = {frame(0).pose.data(), frame(0).speed_bias.data()};
    int n = 15;
    const auto add = [&](double* x, int ambient) {
      prior_.blocks.push_back({ambient, n, std::vector<double>(x, x + ambient)});
      prior_blocks_.push_back(x);
      n += prior_.blocks.back().local();
    };
    if (variant_.calibrated) {
      add(extrinsic_.data(), 7);
      add(camera_.data(), vir::factors::kCameraParameters);
      add(imu_.data(), vir::imu::kImuIntrinsicsSize);
    }
    add(frame(1).pose.data(), 7);
    // Dense, and off from where things are.
    srand(3);
    prior_.J = 100 * (Eigen::MatrixXd::Identity(n, n) + 0.1 * Eigen::MatrixXd::Random(n, n));
    prior_.r0 = Eigen::VectorXd::Random(n);
  }

  void addRanges() {
    node_ = {0.1, -0.2, 0.05, 0.02, 0};
    anchor_ = {2, 1, 1.5, 0.02};
    range_prior_.blocks = {{5, 0, std::vector<double>(5, 0)}, {4, 5, {2.1, 0.9, 1.4, 0}}};
    range_prior_.J = 3 * Eigen::MatrixXd::Identity(9, 9);
    range_prior_.r0 = Eigen::VectorXd::Zero(9);
  }

  void build() {
    make<vir::factors::LinearPriorFactor>(&terms_, prior_blocks_, prior_);
    for (int k = 1; k < kFrames; ++k) {
      Frame &a = frame(k - 1), &b = frame(k);
      const std::vector<double*> both = {a.pose.data(), a.speed_bias.data(), b.pose.data(),
                                         b.speed_bias.data()};
      if (variant_.calibrated) {
        std::vector<double*> all = both;
        all.push_back(imu_.data());
        make<vir::factors::ImuCalibrationFactor>(&terms_, all, *b.link, Scene::kGravity);
      } else {
        make<vir::factors::ImuFactor>(&terms_, both, *b.link, Scene::kGravity);
      }
    }
    for (Point& p : points_) addTermsOf(&p);
    if (!variant_.ranges) return;
    make<vir::factors::LinearPriorFactor>(&range_terms_, {node_.data(), anchor_.data()},
                                          range_prior_);
    for (int k = 0; k < kFrames; ++k) {
      vir::factors::RangeTerm range;
      range.range_m = 2.5 + 0.1 * k;
      const Vec3 motion(0.01, 0, 0.02), lever(0, 0.05, 0.1);
      double* const host = frame(0).pose.data();
      if (k == 0) {
        make<vir::factors::HeadRangeFactor>(&range_terms_, {host, node_.data(), anchor_.data()},
                                            range, motion, lever);
      } else {
        make<vir::factors::WindowRangeFactor>(
            &range_terms_, {host, frame(k).pose.data(), node_.data(), anchor_.data()}, range,
            motion, lever);
      }
    }
  }

  void addTermsOf(Point* p) {
    Frame& host = frame(p->sights.front().first);
    const vir::factors::HostRay& ray = p->ray;
    make<vir::factors::HostSightFactor>(&terms_, {p->x.data()}, ray,
                                        p->sights.front().second.weight);
    terms_.back().landmark = p->x.data();
    for (std::size_t k = 1; k < p->sights.size(); ++k) {
      const auto& [at, sight] = p->sights[k];
      Frame& f = frame(at);
      const double* lin = at < 2 ? f.lin.data() : nullptr;
      if (variant_.calibrated) {
        make<vir::factors::ReprojectionCalibrationFactor>(
            &terms_,
            {host.pose.data(), f.pose.data(), extrinsic_.data(), p->x.data(), camera_.data()}, ray,
            sight)
            .linearizeAt(nullptr, lin);
      } else {
        make<vir::factors::ReprojectionFactor>(
            &terms_, {host.pose.data(), f.pose.data(), p->x.data()}, ray, sight, Scene::T_B_C(),
            vir::factors::CameraVector::Zero())
            .linearizeAt(nullptr, lin);
      }
      terms_.back().landmark = p->x.data();
      terms_.back().robust = 1;
      terms_.back().cauchy = variant_.cauchy;
    }
  }

  template <typename Factor, typename... Args>
  Factor& make(std::vector<vir::window::Term>* list, const std::vector<double*>& blocks,
               Args&&... args) {
    auto f = std::make_unique<Factor>(std::forward<Args>(args)...);
    Factor& out = *f;
    vir::window::Term t;
    t.cost = f.get();
    t.blocks = blocks;
    list->push_back(t);
    costs_.push_back(std::move(f));
    return out;
  }

  WindowVariant variant_;
  Scene scene_;
  std::deque<Frame> frames_;
  std::deque<Point> points_;
  std::array<double, 7> extrinsic_{};
  std::array<double, vir::factors::kCameraParameters> camera_{};
  std::array<double, vir::imu::kImuIntrinsicsSize> imu_{};
  std::array<double, 5> node_{};
  std::array<double, 4> anchor_{};
  vir::factors::LinearPrior prior_, range_prior_;
  std::vector<double*> prior_blocks_;
  std::vector<std::unique_ptr<ceres::CostFunction>> costs_;
  std::vector<vir::window::Term> terms_, range_terms_;
};

}  // namespace vir_test
