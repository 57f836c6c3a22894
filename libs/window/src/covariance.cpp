/// What the short window knows of its own geometry, and what of that goes to the long window.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "window_state.h"

namespace vir::window {
namespace {

using Mat6 = Eigen::Matrix<double, 6, 6>;
using Mat46 = Eigen::Matrix<double, 4, 6>;

/// Ranges of one anchor that a keyframe holds at most before neighbours are averaged.
constexpr std::size_t kMaxRangesPerKeyframe = 16;

/// Added to the information of every state, as a part of what is known of it.
constexpr double kNextToNothing = 1e-12;

/// (position, yaw in O) of a frame from its local coordinates.
Mat46 gaugePart(const Frame& f) {
  Mat46 J = Mat46::Zero();
  J.leftCols<3>().topRows<3>().setIdentity();
  J.block<1, 3>(3, 3) = f.T_W_B().R().row(2);
  return J;
}

/// Position of `f` and yaw (4 rows) or rotation (6 rows) with the shift and turn of `base` taken
/// off: Jacobians with respect to f and to base.
struct Relative {
  Mat6 self = Mat6::Identity();
  Mat6 base = Mat6::Zero();
};
Relative relativeTo(const Frame& base, const Frame& f) {
  Relative out;
  const Mat46 gauge = gaugePart(base);
  const Vec3 arm = f.T_W_B().p - base.T_W_B().p;
  out.base.topRows<3>() = -gauge.topRows<3>();
  out.base.topRows<3>() -= Vec3::UnitZ().cross(arm) * gauge.row(3);
  out.base.bottomRows<3>() = -f.T_W_B().R().transpose().col(2) * gauge.row(3);
  return out;
}

/// (position, yaw) of a relative 6-vector of frame f.
Eigen::Matrix4d gaugeOf(const Mat6& relative, const Frame& f) {
  const Mat46 J = gaugePart(f);
  return J * relative * J.transpose();
}

/// What the newest frame's uncertainty grows by when it is counted from the oldest instead of the
/// second frame. If motions between keyframes were independent this would be the edge itself; where
/// they share a bias or a scale it is larger, and chaining the edges would promise too much.
/// Bounded by once and `kMaxGrowth` times the edge, direction by direction.
Eigen::Matrix4d edgeByGrowth(const Eigen::Matrix4d& edge, const Eigen::Matrix4d& from_first,
                             const Eigen::Matrix4d& from_second, const Vec3& arm) {
  constexpr double kMaxGrowth = 30;
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topRightCorner<3, 1>() = -Vec3::UnitZ().cross(arm);
  const Eigen::Matrix4d growth = T * (from_first - from_second) * T.transpose();
  const Eigen::LLT<Eigen::Matrix4d> llt(edge);
  if (llt.info() != Eigen::Success) return edge;
  const Eigen::Matrix4d L = llt.matrixL();
  Eigen::Matrix4d M = llt.matrixL().solve(growth);
  M = llt.matrixL().solve(M.transpose().eval()).eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eig(0.5 * (M + M.transpose()));
  const Eigen::Vector4d l = eig.eigenvalues().cwiseMax(1.0).cwiseMin(kMaxGrowth);
  const Eigen::Matrix4d V = L * eig.eigenvectors();
  return V * l.asDiagonal() * V.transpose();
}

/// Covariance columns of chosen frames' poses out of the information of all poses.
class PoseCovariance {
 public:
  PoseCovariance(const NormalEquations& eq, const std::vector<int>& frames, bool calibrated,
                 std::size_t further)
      : frames_(frames), calibrated_(calibrated), further_(calibrated ? further : 0) {
    const Eigen::VectorXd s =
        eq.H.diagonal().unaryExpr([](double d) { return d > 0 ? 1.0 / std::sqrt(d) : 1.0; });
    Eigen::MatrixXd A = s.asDiagonal() * eq.H * s.asDiagonal();
    A.diagonal().array() += kNextToNothing;  // states nothing is known of
    const Eigen::LLT<Eigen::MatrixXd> llt(A);
    ok_ = llt.info() == Eigen::Success;
    if (!ok_) return;
    const int n = static_cast<int>(eq.H.rows()), m = 6 * static_cast<int>(frames.size());
    const int c = calibrated ? kCalibrationSize + kFurtherSize * static_cast<int>(further_) : 0;
    Eigen::MatrixXd E = Eigen::MatrixXd::Zero(n, m + c);
    E.bottomRightCorner(c, c).setIdentity();
    for (std::size_t k = 0; k < frames.size(); ++k) {
      for (int i = 0; i < 6; ++i) E(6 * frames[k] + i, 6 * static_cast<int>(k) + i) = 1;
    }
    E = s.asDiagonal() * E;
    llt.matrixL().solveInPlace(E);
    cov_ = E.transpose() * E;
    if (!calibrated) return;
    const Eigen::VectorXd y = llt.matrixL().solve(s.asDiagonal() * eq.b);
    step_ = -E.rightCols<kCalibrationSize>().transpose() * y;
  }
  bool ok() const { return ok_; }
  /// Of the calibration, the blocks behind all frames; nothing if it was held.
  std::optional<CalibrationCovariance> calibration() const {
    static_assert(kCalibrationSize == 6 + factors::kCameraParameters + imu::kImuIntrinsicsSize);
    if (!calibrated_) return std::nullopt;
    return cov_.bottomRightCorner<kCalibrationSize, kCalibrationSize>();
  }
  /// Of the further camera `k`, whose blocks are before those.
  CalibrationChange furtherSigma(std::size_t k, double factor) const {
    const auto behind = kCalibrationSize + kFurtherSize * static_cast<int>(further_ - k);
    CalibrationChange out = CalibrationChange::Zero();
    out.head<kFurtherSize>() =
        (factor * cov_.diagonal().segment<kFurtherSize>(cov_.rows() - behind))
            .cwiseMax(0)
            .cwiseSqrt();
    return out;
  }
  /// Of the distance of that camera from the first, which lies in the direction `u_B` from it.
  double distanceSigma(std::size_t k, const Vec3& u_B) const {
    const auto first = cov_.rows() - kCalibrationSize,
               other = first - kFurtherSize * static_cast<Eigen::Index>(further_ - k);
    const Mat3 difference = cov_.block<3, 3>(first, first) + cov_.block<3, 3>(other, other) -
                            cov_.block<3, 3>(first, other) - cov_.block<3, 3>(other, first);
    return std::sqrt(std::max(0.0, u_B.dot(difference * u_B)));
  }
  /// From where it is to where the terms would have it.
  const CalibrationChange& calibrationStep() const { return step_; }
  Mat6 block(std::size_t a, std::size_t b) const {
    return cov_.block<6, 6>(6 * static_cast<int>(a), 6 * static_cast<int>(b));
  }
  Mat6 relative(const Relative& r, std::size_t self, std::size_t base) const {
    const Mat6 cross = r.self * block(self, base) * r.base.transpose();
    return r.self * block(self, self) * r.self.transpose() +
           r.base * block(base, base) * r.base.transpose() + cross + cross.transpose();
  }

 private:
  static constexpr int kFurtherSize = 6 + factors::kCameraParameters;
  std::vector<int> frames_;
  bool calibrated_;
  std::size_t further_;
  bool ok_ = false;
  Eigen::MatrixXd cov_;
  CalibrationChange step_ = CalibrationChange::Zero();
};

/// As a range, rigid, to two anchors.
void addDifferenceInformation(const WindowState& w, const Frame& f, const HeldRange& r,
                              NormalEquations* eq) {
  const LongWindow& lw = *w.long_window;
  const auto a = lw.anchors().find(r.anchor), reference = lw.anchors().find(*r.reference);
  if (reference == lw.anchors().end() || reference == a) return;
  const RigidRange rigid = rigidRange(w, f, r);
  const factors::NodeRangeDifferenceFactor factor(rigid.term, rigid.motion_O, rigid.lever_O);
  double e = 0;
  Eigen::Matrix<double, 1, 5> Jn;
  Eigen::Matrix<double, 1, 4> J_of[2];
  const AnchorNode* nodes[2] = {&reference->second, &a->second};
  const double* x[3] = {lw.head().x, nodes[0]->x, nodes[1]->x};
  double* J[3] = {Jn.data(), J_of[0].data(), J_of[1].data()};
  factor.Evaluate(x, &e, J);
  for (const int i : lw.frozen()) Jn[i] = 0;
  eq->H.topLeftCorner<5, 5>() += Jn.transpose() * Jn;
  for (int i = 0; i < 2; ++i) {
    if (nodes[i]->fixed) J_of[i].setZero();
  }
  for (int i = 0; i < 2; ++i) {
    const int c = eq->offsetOf(nodes[i]->x);
    eq->H.block<5, 4>(0, c) += Jn.transpose() * J_of[i];
    eq->H.block<4, 5>(c, 0) += J_of[i].transpose() * Jn;
    for (int k = 0; k < 2; ++k) {
      eq->H.block<4, 4>(c, eq->offsetOf(nodes[k]->x)) += J_of[i].transpose() * J_of[k];
    }
  }
}

void addRangeInformation(const WindowState& w, NormalEquations* eq) {
  const LongWindow& lw = *w.long_window;
  for (const auto& f : w.frames) {
    for (const HeldRange& r : f->ranges) {
      const auto known = lw.anchors().find(r.anchor);
      if (known == lw.anchors().end()) continue;
      const AnchorNode& a = known->second;
      if (r.reference) {
        addDifferenceInformation(w, *f, r, eq);
        continue;
      }
      const int c = eq->offsetOf(a.x);
      // The short window's own geometry is far better known than a range: taken as rigid here.
      const RigidRange range = rigidRange(w, *f, r);
      const factors::NodeRangeFactor factor(range.term, range.motion_O, range.lever_O);
      double e = 0;
      Eigen::Matrix<double, 1, 5> Jn;
      Eigen::Matrix<double, 1, 4> Ja;
      const double* x[2] = {lw.head().x, a.x};
      double* J[2] = {Jn.data(), Ja.data()};
      factor.Evaluate(x, &e, J);
      if (a.fixed) Ja.setZero();
      for (const int i : lw.frozen()) Jn[i] = 0;
      eq->H.topLeftCorner<5, 5>() += Jn.transpose() * Jn;
      eq->H.block<5, 4>(0, c) += Jn.transpose() * Ja;
      eq->H.block<4, 5>(c, 0) += Ja.transpose() * Jn;
      eq->H.block<4, 4>(c, c) += Ja.transpose() * Ja;
    }
  }
}

}  // namespace

RigidRange rigidRange(const WindowState& w, const Frame& f, const HeldRange& r) {
  const LongWindow& lw = *w.long_window;
  const Pose T_O_B = f.T_W_B();
  const Vec3 offset = lw.options().ranges_at_own_time ? Vec3(r.motion + r.lever) : r.lever;
  const Vec3 offset_O = T_O_B * offset - w.frames.front()->T_W_B().p;
  // What a scale that is held at 1 cannot change need not be told from the lever: one rounding
  // less.
  const Vec3 motion_O = lw.scaleFrozen() ? Vec3(Vec3::Zero()) : Vec3(offset_O - T_O_B.q * r.lever);
  return {lw.termOf(r.anchor, r.range_m, r.sigma_m), motion_O, offset_O - motion_O};
}

NormalEquations informationOf(WindowState& w) {
  std::size_t leading = 0;
  const std::vector<BlockRef> order = leadingOrder(w, &leading);
  std::vector<int> sizes;
  int first = 0;
  for (std::size_t k = 0; k < leading; ++k) {
    sizes.push_back(order[k].local());
    first += sizes.back();
  }
  NormalEquations out;
  if (w.information_known && !w.minimiser.information().blocks.empty()) {
    out = w.minimiser.information();
  } else {
    TermSet set(w);
    set.addAll();
    out = eliminateLandmarks(set.terms(), order);
    const NormalEquations all = out;
    LeadingBlocks blocks;
    // States nothing is known of: as little is added as lets them be eliminated.
    for (double part = kNextToNothing; part < 1; part *= 1e3) {
      out.H = all.H;
      out.b = all.b;
      for (int i = 0; i < first; ++i) out.H(i, i) += part * (out.H(i, i) > 0 ? out.H(i, i) : 1);
      if (blocks.eliminate(sizes, &out.H, &out.b)) break;
    }
    const auto rest = out.H.rows() - first;
    out.H = out.H.bottomRightCorner(rest, rest).eval();
    out.H.triangularView<Eigen::StrictlyLower>() = out.H.transpose();
    out.b = out.b.tail(rest).eval();
    out.blocks.erase(out.blocks.begin(), out.blocks.begin() + static_cast<std::ptrdiff_t>(leading));
    for (BlockRef& b : out.blocks) b.offset -= first;
  }
  // Without the head of the long window and the anchors, of which these terms know nothing.
  out.blocks.resize(order.size() - leading);
  const int n = out.blocks.back().offset + out.blocks.back().local();
  out.H = out.H.topLeftCorner(n, n).eval();
  out.b = out.b.head(n).eval();
  return out;
}

namespace {

/// Factor on the covariance of camera and IMU. Below 1 only while the newest frame sees enough: in
/// the dark the IMU is as uncertain as it always was.
double varianceFactor(const WindowState& w) {
  constexpr double kLeast = 0.1, kMost = 4;
  constexpr int kSeeing = 20;
  if (!w.long_window || !w.long_window->options().noise_from_residuals) return 1;
  int seen = 0;
  for (const auto& [id, l] : w.landmarks) {
    seen += l.has_depth && l.sights.back().frame == w.frames.back().get();
  }
  return std::clamp(w.sight_level.mean_square, seen < kSeeing ? 1.0 : kLeast, kMost);
}

}  // namespace

void updateCovariance(WindowState& w) {
  const int n = static_cast<int>(w.frames.size());
  if (n < 2) return;
  const PoseCovariance cov(informationOf(w), {0, 1, n - 1}, w.calibrating(), w.further.size());
  if (!cov.ok()) return;
  const Frame &first = *w.frames[0], &second = *w.frames[1], &newest = *w.frames.back();
  w.covariance.newest = cov.relative(relativeTo(first, newest), 2, 0);
  const Mat46 gauge = gaugePart(first);
  w.covariance.claim = gauge * cov.block(0, 0) * gauge.transpose();
  const Eigen::Matrix4d edge = gaugeOf(cov.relative(relativeTo(first, second), 1, 0), second);
  w.covariance.edge = edge;
  if (n > 2) {
    w.covariance.edge =
        edgeByGrowth(edge, gaugeOf(w.covariance.newest, newest),
                     gaugeOf(cov.relative(relativeTo(second, newest), 2, 1), newest),
                     newest.T_W_B().p - second.T_W_B().p);
  }
  const double factor = varianceFactor(w);
  w.covariance.calibration = cov.calibration();
  w.covariance.calibration_step = cov.calibrationStep();
  if (w.covariance.calibration) *w.covariance.calibration *= std::max(1.0, factor);
  w.covariance.further.clear();
  w.covariance.distance_sigma_m.clear();
  for (std::size_t k = 0; w.calibrating() && k < w.further.size(); ++k) {
    w.covariance.further.push_back(sigmaOf(cov.furtherSigma(k, std::max(1.0, factor))));
    const Vec3 away = factors::poseFrom(w.further[k].extrinsic).p - w.T_B_C().p;
    w.covariance.distance_sigma_m.push_back(cov.distanceSigma(k, away.normalized()));
  }
  w.covariance.newest *= factor;
  w.covariance.edge *= factor;
  w.covariance.claim *= factor;
  if (!w.long_window || w.long_window->empty()) return;
  NormalEquations joint = w.long_window->eliminate();
  if (w.ranging()) addRangeInformation(w, &joint);
  w.long_window->setJointInformation(joint);
}

void handToLongWindow(WindowState& w) {
  Frame &oldest = *w.frames[0], &second = *w.frames[1];
  std::vector<HeldRange> ranges = std::move(oldest.ranges);
  const Quat q_O_B = oldest.T_W_B().q;
  for (HeldRange& r : ranges) {
    r.motion = q_O_B * r.motion;
    r.lever = q_O_B * r.lever;
  }
  if (!w.long_window->options().gauge_free_prior) {
    w.long_window->setOdometryClaim(w.covariance.claim);
  }
  w.long_window->advance(second.t, second.T_W_B(), std::move(ranges), w.covariance.edge);
}

void moveRanges(Frame* from, Frame* to) {
  const Pose T_to_from = to->T_W_B().inverse() * from->T_W_B();
  for (HeldRange r : from->ranges) {
    const Vec3 lever = T_to_from.q * r.lever;
    r.motion = T_to_from * Vec3(r.motion + r.lever) - lever;
    r.lever = lever;
    to->ranges.push_back(r);
  }
  from->ranges.clear();
  mergeRanges(&to->ranges, kMaxRangesPerKeyframe);
}

}  // namespace vir::window
