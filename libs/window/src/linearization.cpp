#include "linearization.h"

#include <ceres/cost_function.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <type_traits>

#include "add_square.h"
#include "vir/factors/linear_prior_factor.h"
#include "vir/factors/pose_manifold.h"

namespace vir::window {
namespace {

using Entry = TermLayout::Entry;

int localSize(int ambient) { return ambient == 7 ? 6 : ambient; }

[[noreturn]] void cannotEvaluate() {
  throw std::runtime_error("window: a residual could not be evaluated");
}

/// Factor on residual and Jacobians of what has this squared norm, and the loss itself.
struct Robust {
  double weight = 1, loss = 0;
};
Robust robustOf(const Term& t, double squares) {
  const double b = t.robust * t.robust;
  if (t.robust <= 0) return {1, squares};
  if (t.cauchy) return {1 / std::sqrt(1 + squares / b), b * std::log1p(squares / b)};
  if (squares <= b) return {1, squares};
  const double norm = std::sqrt(squares);
  return {std::sqrt(t.robust / norm), 2 * t.robust * norm - b};
}

/// An inertial link: of both frames' poses, speeds and biases, and perhaps the IMU's intrinsics.
bool isLink(const Entry& e, int rows) {
  return e.shape == TermShape::dense && rows == 15 && (e.blocks == 4 || e.blocks == 5);
}

}  // namespace

double addToSums(const Entry& e, const double* r, int rows, TermSums* sums) {
  const Term& t = *e.term;
  const double squares = Eigen::Map<const Eigen::VectorXd>(r, rows).squaredNorm();
  const Robust robust = robustOf(t, squares);
  sums->cost += 0.5 * robust.loss;
  if (t.robust > 0) sums->sight_squares += squares;
  if (isLink(e, rows)) {
    sums->link_squares += Eigen::Map<const Eigen::Matrix<double, 9, 1>>(r).squaredNorm();
    ++sums->links;
  }
  return robust.weight;
}

void geometriesOf(const TermLayout& layout, bool linearized, SightGeometries* out) {
  out->clear();
  for (const TermLayout::Pair& p : layout.pairs()) {
    const double* i = linearized && p.lin_i ? p.lin_i : p.pose_i;
    const double* j = linearized && p.lin_j ? p.lin_j : p.pose_j;
    const Pose T_B_Ci = p.extrinsic ? factors::poseFrom(p.extrinsic) : p.T_B_C;
    out->emplace_back(i ? factors::poseFrom(i) : Pose(), j ? factors::poseFrom(j) : Pose(), T_B_Ci,
                      p.extrinsic_j ? factors::poseFrom(p.extrinsic_j) : T_B_Ci);
  }
}

namespace {

template <typename Factor>
constexpr bool kCalibrated = std::is_same_v<Factor, factors::ReprojectionCalibrationFactor>;

/// One sight between its frames.
template <typename Factor>
Vec2 residualOf(const Term& t, const factors::SightGeometry& between,
                factors::ReprojectionJacobians* J) {
  const auto& f = static_cast<const Factor&>(*t.cost);
  const Vec3 landmark(t.landmark);
  if constexpr (kCalibrated<Factor>) {
    return factors::reprojectionResidual(f.host(), f.sight(), between, landmark,
                                         factors::CameraVector(t.blocks[4]), J);
  } else {
    return factors::reprojectionResidual(f.host(), f.sight(), between, landmark, f.camera(), J);
  }
}

}  // namespace

TermSums evaluate(const TermLayout& layout) {
  TermSums sums;
  std::vector<double> r(2);
  SightGeometries now;
  geometriesOf(layout, false, &now);
  for (const Entry& e : layout.entries()) {
    const Term& t = *e.term;
    if (e.shape == TermShape::sight || e.shape == TermShape::calibrated_sight) {
      const factors::SightGeometry& between = now[static_cast<std::size_t>(e.pair)];
      const Vec2 residual =
          e.shape == TermShape::sight
              ? residualOf<factors::ReprojectionFactor>(t, between, nullptr)
              : residualOf<factors::ReprojectionCalibrationFactor>(t, between, nullptr);
      addToSums(e, residual.data(), 2, &sums);
      continue;
    }
    if (e.shape == TermShape::rig_sight || e.shape == TermShape::rig_pair) {
      const Vec2 residual = rigResidualOf(e, now[static_cast<std::size_t>(e.pair)], nullptr);
      addToSums(e, residual.data(), 2, &sums);
      continue;
    }
    const int rows = t.cost->num_residuals();
    r.resize(std::max(r.size(), static_cast<std::size_t>(rows)));
    if (!t.cost->Evaluate(t.blocks.data(), r.data(), nullptr)) cannotEvaluate();
    addToSums(e, r.data(), rows, &sums);
  }
  return sums;
}

void Linearization::linearize(const TermLayout& layout) {
  H_.setZero(layout.size(), layout.size());
  b_.setZero(layout.size());
  own_.assign(layout.landmarks().size(), OwnBlock());
  coupling_.assign(static_cast<std::size_t>(layout.slots()), Coupling::Zero());
  sums_ = TermSums();
  geometriesOf(layout, false, &now_);
  geometriesOf(layout, true, &linearized_);
  std::size_t landmark = 0;
  for (std::size_t k = 0; k < layout.entries().size(); ++k) {
    const Entry& e = layout.entries()[k];
    OwnBlock* own = nullptr;
    if (e.term->landmark) {
      while (layout.landmarks()[landmark].x != e.term->landmark) ++landmark;
      own = &own_[landmark];
    }
    switch (e.shape) {
      case TermShape::dense:
        addDense(layout, e);
        break;
      case TermShape::prior:
        addPrior(layout, e);
        break;
      case TermShape::sight:
        addSight<factors::ReprojectionFactor>(layout, e, own);
        break;
      case TermShape::calibrated_sight:
        addSight<factors::ReprojectionCalibrationFactor>(layout, e, own);
        break;
      case TermShape::rig_sight:
      case TermShape::rig_pair:
        addRigSight(layout, e, own);
        break;
      case TermShape::any_of_landmark:
        addOfLandmark(layout, e, own);
        break;
    }
  }
  flush<20>(&with_calibration_);
  flush<6>(&without_);
  flushRig();
}

template <int size>
void Linearization::flush(CommonSum* sum) {
  const int host = sum->columns[0];
  if (host >= 0) {
    const auto H = sum->H.topLeftCorner<size, size>();
    H_.block<6, 6>(host, host) += H.template topLeftCorner<6, 6>();
    b_.segment<6>(host) += sum->b.head<6>();
    if constexpr (size == 20) {
      const int extrinsic = sum->columns[1], camera = sum->columns[2];
      H_.block<6, 6>(host, extrinsic) += H.template block<6, 6>(0, 6);
      H_.block<6, 8>(host, camera) += H.template block<6, 8>(0, 12);
      H_.block<6, 6>(extrinsic, extrinsic) += H.template block<6, 6>(6, 6);
      H_.block<6, 8>(extrinsic, camera) += H.template block<6, 8>(6, 12);
      H_.block<8, 8>(camera, camera) += H.template block<8, 8>(12, 12);
      b_.segment<6>(extrinsic) += sum->b.segment<6>(6);
      b_.segment<8>(camera) += sum->b.segment<8>(12);
    }
  }
  std::fill(sum->columns, sum->columns + 3, -1);
  sum->H.setZero();
  sum->b.setZero();
}

template <typename Factor>
void Linearization::addSight(const TermLayout& layout, const Entry& e, OwnBlock* own) {
  static_assert(factors::kCameraParameters == 8);
  constexpr bool calibrated = kCalibrated<Factor>;
  constexpr int kCommon = calibrated ? 20 : 6;
  const Term& t = *e.term;
  const auto pair = static_cast<std::size_t>(e.pair);
  const bool elsewhere = layout.pairs()[pair].linearizedElsewhere();
  factors::ReprojectionJacobians J;
  const Vec2 r = residualOf<Factor>(t, now_[pair], elsewhere ? nullptr : &J);
  if (elsewhere) residualOf<Factor>(t, linearized_[pair], &J);
  const double weight = addToSums(e, r.data(), 2, &sums_);
  const Vec2 residual = weight * r;
  Eigen::Matrix<double, kCommon, 2> common;
  common.template topRows<6>() = weight * J.pose_i.transpose();
  if constexpr (calibrated) {
    common.template middleRows<6>(6) = weight * J.extrinsic.transpose();
    common.template bottomRows<8>() = weight * J.camera.transpose();
  }
  const Eigen::Matrix<double, 6, 2> Jj = weight * J.pose_j.transpose();
  const Eigen::Matrix<double, 3, 2> Jl = weight * J.landmark.transpose();

  CommonSum& sum = calibrated ? with_calibration_ : without_;
  const int i = layout.columnOf(e, 0), j = layout.columnOf(e, 1);
  if (sum.columns[0] != i) {
    flush<kCommon>(&sum);
    sum.columns[0] = i;
    if (calibrated) {
      sum.columns[1] = layout.columnOf(e, 2);
      sum.columns[2] = layout.columnOf(e, 4);
    }
  }
  own->H += Jl.lazyProduct(Jl.transpose());
  own->b += Jl.lazyProduct(residual);
  if constexpr (calibrated) {
    addSquare<20>(common, &sum.H);
    sum.b += common.lazyProduct(residual);
  } else {
    sum.H.template topLeftCorner<6, 6>() += common.lazyProduct(common.transpose());
    sum.b.template head<6>() += common.lazyProduct(residual);
  }
  H_.block<6, 6>(j, j) += Jj.lazyProduct(Jj.transpose());
  H_.block<6, 6>(i, j) += common.template topRows<6>().lazyProduct(Jj.transpose());
  b_.segment<6>(j) += Jj.lazyProduct(residual);
  coupling(layout, e, 0).topRows<6>() += common.template topRows<6>().lazyProduct(Jl.transpose());
  coupling(layout, e, 1).topRows<6>() += Jj.lazyProduct(Jl.transpose());
  if constexpr (calibrated) {
    const auto Je = common.template middleRows<6>(6);
    const auto Jc = common.template bottomRows<8>();
    H_.block<6, 6>(j, sum.columns[1]) += Jj.lazyProduct(Je.transpose());
    H_.block<6, 8>(j, sum.columns[2]) += Jj.lazyProduct(Jc.transpose());
    coupling(layout, e, 2).topRows<6>() += Je.lazyProduct(Jl.transpose());
    coupling(layout, e, 4) += Jc.lazyProduct(Jl.transpose());
  }
}

/// Residual and all Jacobians, weighted, side by side.
void Linearization::evaluateStacked(const Entry& e) {
  const Term& t = *e.term;
  const std::vector<int>& sizes = t.cost->parameter_block_sizes();
  const int rows = t.cost->num_residuals();
  int columns = 0, values = 0;
  stacked_.clear();
  for (const int size : sizes) {
    stacked_.push_back(columns);
    columns += localSize(size);
    values += rows * size;
  }
  raw_.resize(std::max(raw_.size(), static_cast<std::size_t>(values)));
  pointers_.clear();
  values = 0;
  for (const int size : sizes) {
    pointers_.push_back(raw_.data() + values);
    values += rows * size;
  }
  r_.resize(rows);
  if (!t.cost->Evaluate(t.blocks.data(), r_.data(), pointers_.data())) cannotEvaluate();
  const double weight = addToSums(e, r_.data(), rows, &sums_);
  J_.resize(rows, columns);
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const int local = localSize(sizes[k]);
    J_.middleCols(stacked_[k], local) =
        Eigen::Map<const RowMajor>(pointers_[k], rows, sizes[k]).leftCols(local);
  }
  if (weight != 1) {
    J_ *= weight;
    r_ *= weight;
  }
}

void Linearization::addDense(const TermLayout& layout, const Entry& e) {
  evaluateStacked(e);
  const auto n = J_.cols();
  product_.setZero(n, n);
  product_.selfadjointView<Eigen::Upper>().rankUpdate(J_.transpose());
  product_.triangularView<Eigen::StrictlyLower>() = product_.transpose();
  gradient_.noalias() = J_.transpose() * r_;
  scatter(layout, e, stacked_);
}

void Linearization::addPrior(const TermLayout& layout, const Entry& e) {
  const auto& factor = dynamic_cast<const factors::LinearPriorFactor&>(*e.term->cost);
  double squared = 0;
  factor.linearize(e.term->blocks.data(), &product_, &gradient_, &squared);
  sums_.cost += 0.5 * squared;
  stacked_.clear();
  for (const factors::LinearPrior::Block& b : factor.prior().blocks) stacked_.push_back(b.offset);
  scatter(layout, e, stacked_);
}

/// Adds product_ and gradient_, whose blocks begin at `columns`, to H and b.
void Linearization::scatter(const TermLayout& layout, const Entry& e,
                            const std::vector<int>& columns) {
  const std::vector<int>& sizes = e.term->cost->parameter_block_sizes();
  for (int k = 0; k < e.blocks; ++k) {
    const int at = layout.columnOf(e, k), from = columns[static_cast<std::size_t>(k)];
    const int size = localSize(sizes[static_cast<std::size_t>(k)]);
    if (at < 0) continue;
    b_.segment(at, size) += gradient_.segment(from, size);
    for (int m = 0; m < e.blocks; ++m) {
      const int other = layout.columnOf(e, m);
      if (other < at) continue;
      const int other_size = localSize(sizes[static_cast<std::size_t>(m)]);
      H_.block(at, other, size, other_size) +=
          product_.block(from, columns[static_cast<std::size_t>(m)], size, other_size);
    }
  }
}

void Linearization::addOfLandmark(const TermLayout& layout, const Entry& e, OwnBlock* own) {
  const std::vector<int>& sizes = e.term->cost->parameter_block_sizes();
  evaluateStacked(e);
  // Two rows: not worth what Eigen does for large products.
  product_ = J_.transpose().lazyProduct(J_);
  gradient_.noalias() = J_.transpose() * r_;
  scatter(layout, e, stacked_);
  int landmark = 0;
  while (layout.columnOf(e, landmark) != TermLayout::kLandmark) ++landmark;
  const int from = stacked_[static_cast<std::size_t>(landmark)];
  own->H += product_.block<3, 3>(from, from);
  own->b += gradient_.segment<3>(from);
  for (int k = 0; k < e.blocks; ++k) {
    if (layout.columnOf(e, k) < 0) continue;
    const int size = localSize(sizes[static_cast<std::size_t>(k)]);
    if (size > kWidest) throw std::logic_error("window: a sight touches a wider block");
    coupling(layout, e, k).topRows(size) +=
        product_.block(stacked_[static_cast<std::size_t>(k)], from, size, 3);
  }
}

}  // namespace vir::window
