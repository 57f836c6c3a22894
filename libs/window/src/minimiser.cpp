#include "minimiser.h"

#include <algorithm>
#include <cmath>

#include "vir/factors/pose_manifold.h"

namespace vir::window {
namespace {

/// Hardly damped: Ceres' default (1e4) holds back what is weakly observed, scale and calibration,
/// and two iterations never catch up. A step that makes things worse is taken back all the same.
constexpr double kInitialRadius = 1e8;
constexpr double kMaxRadius = 1e16, kMinRadius = 1e-32;
constexpr double kMinDiagonal = 1e-6, kMaxDiagonal = 1e32;
constexpr double kFunctionTolerance = 1e-5, kParameterTolerance = 1e-8, kGradientTolerance = 1e-10;
/// Damping by less does not show in the information that is left.
constexpr double kRadiusOfInformation = 1e6;
constexpr double kLeastPartOfPrediction = 1e-3;
constexpr int kInvalidSteps = 5;

/// Radius of the trust region; smaller means more damping.
class TrustRegion {
 public:
  double radius() const { return radius_; }
  void accepted(double part_of_prediction) {
    radius_ /= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * part_of_prediction - 1.0, 3));
    radius_ = std::min(kMaxRadius, radius_);
    decrease_ = 2;
  }
  explicit TrustRegion(double refused_radius) : refused_radius_(refused_radius) {}
  void rejected() {
    radius_ = std::min(radius_ / decrease_, refused_radius_);
    decrease_ *= 2;
  }

 private:
  double radius_ = kInitialRadius, decrease_ = 2, refused_radius_;
};

double clamped(double d) { return std::clamp(d, kMinDiagonal, kMaxDiagonal); }

}  // namespace

void Minimiser::setUp(const LeastSquares& problem) {
  problem_ = &problem;
  leading_sizes_.clear();
  leading_columns_ = 0;
  for (std::size_t k = 0; k < problem.leading; ++k) {
    leading_sizes_.push_back(problem.order[k].local());
    leading_columns_ += leading_sizes_.back();
  }
  terms_.layout.build(*problem.terms, problem.order);
  static const std::vector<Term> kNone;
  const auto rest = problem.order.begin() + static_cast<std::ptrdiff_t>(problem.leading);
  further_.layout.build(problem.further ? *problem.further : kNone,
                        std::vector<BlockRef>(rest, problem.order.end()));
  scaled_ = false;
  information_ = NormalEquations();
}

Minimiser::Point Minimiser::linearizeNext() {
  terms_.next.linearize(terms_.layout);
  further_.next.linearize(further_.layout);
  Point out{terms_.next.sums(), false};
  out.sums.cost += further_.next.sums().cost;
  out.finite = std::isfinite(out.sums.cost) && terms_.next.b().allFinite();
  return out;
}

Minimiser::Point Minimiser::evaluateNext() {
  Point out{evaluate(terms_.layout), false};
  out.sums.cost += evaluate(further_.layout).cost;
  out.finite = std::isfinite(out.sums.cost);
  return out;
}

void Minimiser::swapLinearizations() {
  std::swap(terms_.now, terms_.next);
  std::swap(further_.now, further_.next);
}

/// Squared norm of each column of the Jacobian, scaled as it was at the start.
void Minimiser::updateDamping() {
  const std::size_t landmarks = terms_.layout.landmarks().size();
  diagonal_ = terms_.now.H().diagonal();
  diagonal_.tail(further_.layout.size()) += further_.now.H().diagonal();
  landmark_diagonal_.resize(landmarks);
  for (std::size_t k = 0; k < landmarks; ++k) {
    landmark_diagonal_[k] = terms_.now.own(k).H.diagonal();
  }
  const auto scale_of = [](double d) { return 1 / (1 + std::sqrt(std::max(d, 0.0))); };
  if (!scaled_) {
    scale_ = diagonal_.unaryExpr(scale_of);
    landmark_scale_.resize(landmarks);
    for (std::size_t k = 0; k < landmarks; ++k) {
      landmark_scale_[k] = landmark_diagonal_[k].unaryExpr(scale_of);
    }
    scaled_ = true;
  }
  const auto scaled = [](double d, double s) { return clamped(d * s * s) / (s * s); };
  diagonal_ = diagonal_.binaryExpr(scale_, scaled);
  for (std::size_t k = 0; k < landmarks; ++k) {
    landmark_diagonal_[k] = landmark_diagonal_[k].binaryExpr(landmark_scale_[k], scaled).eval();
  }
}

/// What is left of the information of `terms` once landmarks and leading blocks are eliminated.
void Minimiser::buildReduced() {
  const int n = terms_.layout.size(), rest = n - leading_columns_;
  information_.H = H_.bottomRightCorner(rest, rest);
  information_.H.triangularView<Eigen::StrictlyLower>() = information_.H.transpose();
  information_.b = b_.tail(rest);
  information_.blocks = further_.layout.blocks();
}

bool Minimiser::findStep(double radius) {
  damping_ = diagonal_ / radius;
  landmark_damping_ = landmark_diagonal_;
  for (Vec3& d : landmark_damping_) d /= radius;
  H_ = terms_.now.H();
  b_ = terms_.now.b();
  if (!eliminateDamped(terms_.layout, terms_.now, landmark_damping_, &H_, &b_, &inverses_)) {
    return false;
  }
  H_.diagonal().head(leading_columns_) += damping_.head(leading_columns_);
  if (!leading_.eliminate(leading_sizes_, &H_, &b_)) return false;
  buildReduced();
  const int rest = further_.layout.size();
  auto H = H_.bottomRightCorner(rest, rest);
  auto b = b_.tail(rest);
  H += further_.now.H();
  b += further_.now.b();
  H.diagonal() += damping_.tail(rest);
  for (const int column : problem_->held) {
    const int c = column - leading_columns_;
    H.row(c).setZero();
    H.col(c).setZero();
    H(c, c) = 1;
    b[c] = 0;
  }
  llt_.compute(H);
  if (llt_.info() != Eigen::Success) return false;
  step_.resize(terms_.layout.size());
  step_.tail(rest) = -llt_.solve(b);
  leading_.backSubstitute(&step_);
  landmark_step_.resize(terms_.layout.landmarks().size());
  bool finite = step_.allFinite();
  for (std::size_t k = 0; k < landmark_step_.size(); ++k) {
    const TermLayout::LandmarkTerms& l = terms_.layout.landmarks()[k];
    Vec3 right = terms_.now.own(k).b;
    for (int s = l.first_slot; s < l.first_slot + l.slots; ++s) {
      const TermLayout::Slot& slot = terms_.layout.slot(s);
      right += terms_.now.coupling(s).topRows(slot.size).transpose() *
               step_.segment(slot.offset, slot.size);
    }
    landmark_step_[k] = -inverses_[k] * right;
    finite = finite && landmark_step_[k].allFinite();
  }
  return finite;
}

/// Of the cost, by the linear model: (H + D) step = -b, and no step of what is held.
double Minimiser::predictedDecrease() const {
  Eigen::VectorXd gradient = terms_.now.b();
  gradient.tail(further_.layout.size()) += further_.now.b();
  double sum = step_.dot(damping_.cwiseProduct(step_)) - gradient.dot(step_);
  for (std::size_t k = 0; k < landmark_step_.size(); ++k) {
    const Vec3& step = landmark_step_[k];
    sum += step.dot(landmark_damping_[k].cwiseProduct(step)) - terms_.now.own(k).b.dot(step);
  }
  return 0.5 * sum;
}

bool Minimiser::withoutGradient() const {
  Eigen::VectorXd gradient = terms_.now.b();
  gradient.tail(further_.layout.size()) += further_.now.b();
  for (const int c : problem_->held) gradient[c] = 0;
  double largest = gradient.size() ? gradient.cwiseAbs().maxCoeff() : 0;
  for (std::size_t k = 0; k < terms_.layout.landmarks().size(); ++k) {
    largest = std::max(largest, terms_.now.own(k).b.cwiseAbs().maxCoeff());
  }
  return largest <= kGradientTolerance;
}

void Minimiser::saveBlocks() {
  before_.clear();
  for (const BlockRef& b : terms_.layout.blocks()) {
    before_.insert(before_.end(), b.data, b.data + b.ambient);
  }
  for (const auto& l : terms_.layout.landmarks()) before_.insert(before_.end(), l.x, l.x + 3);
  norm_before_ =
      Eigen::Map<const Eigen::VectorXd>(before_.data(), static_cast<Eigen::Index>(before_.size()))
          .norm();
}

void Minimiser::restoreBlocks() {
  const double* x = before_.data();
  for (const BlockRef& b : terms_.layout.blocks()) {
    std::copy(x, x + b.ambient, b.data);
    x += b.ambient;
  }
  for (const auto& l : terms_.layout.landmarks()) {
    std::copy(x, x + 3, l.x);
    x += 3;
  }
}

void Minimiser::applyStep() {
  for (const BlockRef& b : terms_.layout.blocks()) {
    const double* d = step_.data() + b.offset;
    if (b.ambient == 7) {
      double moved[7];
      factors::posePlus(b.data, d, moved);
      std::copy(moved, moved + 7, b.data);
    } else {
      for (int i = 0; i < b.ambient; ++i) b.data[i] += d[i];
    }
  }
  for (std::size_t k = 0; k < landmark_step_.size(); ++k) {
    for (int i = 0; i < 3; ++i) terms_.layout.landmarks()[k].x[i] += landmark_step_[k][i];
  }
}

bool Minimiser::stepIsSmall() const {
  double squares = step_.squaredNorm();
  for (const Vec3& d : landmark_step_) squares += d.squaredNorm();
  return std::sqrt(squares) <= kParameterTolerance * (norm_before_ + kParameterTolerance);
}

Minimised Minimiser::minimise(const LeastSquares& problem, int iterations) {
  setUp(problem);
  Minimised out;
  Point now = linearizeNext();
  out.iterations = 1;
  out.initial_cost = now.sums.cost;
  out.sums = now.sums;
  if (!now.finite) return out;
  swapLinearizations();
  updateDamping();
  saveBlocks();
  const std::vector<double> start = before_;
  TrustRegion region(problem.refused_radius);
  bool moved = false;
  int invalid = 0;
  for (int it = 0; it < iterations && !withoutGradient(); ++it) {
    if (region.radius() < kMinRadius) break;
    ++out.iterations;
    const bool valid = findStep(region.radius());
    const double predicted = valid ? predictedDecrease() : 0;
    if (!valid || !(predicted > 0)) {
      region.rejected();
      if (++invalid < kInvalidSteps) continue;
      before_ = start;
      restoreBlocks();
      information_ = NormalEquations();
      return out;
    }
    invalid = 0;
    applyStep();
    // The Jacobians are needed if this is not the last step, and nearly every step is good.
    const bool last = it + 1 == iterations;
    const Point next = last ? evaluateNext() : linearizeNext();
    const double change = now.sums.cost - next.sums.cost;
    const bool converged = next.finite && ((moved && stepIsSmall()) ||
                                           std::abs(change) <= kFunctionTolerance * now.sums.cost);
    if (converged || !next.finite || !(change / predicted > kLeastPartOfPrediction)) {
      restoreBlocks();
      if (converged) {
        --out.iterations;  // not taken
        break;
      }
      region.rejected();
      continue;
    }
    moved = true;
    region.accepted(change / predicted);
    now = next;
    saveBlocks();
    if (last) break;
    swapLinearizations();
    updateDamping();
  }
  // Damped this much, it would be too little or too much.
  if (region.radius() < kRadiusOfInformation) information_ = NormalEquations();
  out.sums = now.sums;
  out.usable = true;
  return out;
}

}  // namespace vir::window
