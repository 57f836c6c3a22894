#include "vir/ranging/gaussian_process.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <nlopt.hpp>
#include <numeric>
#include <stdexcept>

#include "vir/core/angles.h"

namespace vir::ranging {
namespace {

constexpr int kEvaluations = 60;
/// Keeps the covariance positive definite when the noise is tiny; relative to the signal's
/// variance.
constexpr double kJitter = 1e-9;

Eigen::MatrixXd covariance(const Eigen::MatrixXd& square, const Eigen::VectorXd& noise_variance,
                           double signal, double length) {
  Eigen::MatrixXd K = signal * signal * (-0.5 / (length * length) * square.array()).exp().matrix();
  K.diagonal() += noise_variance;
  K.diagonal().array() += kJitter * signal * signal;
  return K;
}

struct Objective {
  const GaussianProcess* process;
  Eigen::Vector3d best;
  double best_value;
};

double evaluate(const std::vector<double>& theta, std::vector<double>& gradient, void* data) {
  auto* objective = static_cast<Objective*>(data);
  Eigen::Vector3d g;
  const Eigen::Vector3d at(theta[0], theta[1], theta[2]);
  double value = objective->process->logLikelihood(at, gradient.empty() ? nullptr : &g);
  if (!std::isfinite(value)) {
    value = -1e12;
    g.setZero();
  }
  if (value > objective->best_value) {
    objective->best_value = value;
    objective->best = at;
  }
  for (std::size_t k = 0; k < gradient.size(); ++k) gradient[k] = g[static_cast<int>(k)];
  return value;
}

}  // namespace

GaussianProcess::GaussianProcess(const std::vector<double>& x, const std::vector<double>& y,
                                 const GaussianProcessOptions& options) {
  if (x.size() != y.size() || x.size() < 3) {
    throw std::invalid_argument("a Gaussian process needs at least 3 samples of x and y, got " +
                                std::to_string(x.size()) + " and " + std::to_string(y.size()));
  }
  const auto finite = [](double v) { return std::isfinite(v); };
  if (!std::all_of(x.begin(), x.end(), finite) || !std::all_of(y.begin(), y.end(), finite)) {
    throw std::invalid_argument("a sample for a Gaussian process is not finite");
  }
  factor_ = std::max(1.0, options.correlation_factor);
  gather(x, y, std::max(options.max_points, 3));
  optimise(options.min_noise);
  prepare();
}

/// Bins of equal width in x; a sample alone stays what it is.
void GaussianProcess::gather(const std::vector<double>& x, const std::vector<double>& y,
                             int max_points) {
  std::vector<std::size_t> order(x.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return x[a] < x[b]; });
  lowest_ = x[order.front()];
  highest_ = x[order.back()];
  const bool binned = x.size() > static_cast<std::size_t>(max_points);
  const double width = std::max((highest_ - lowest_) / max_points, 1e-12);
  std::vector<double> xs, ys, counts;
  for (std::size_t i = 0; i < order.size();) {
    double sum_x = 0, sum_y = 0, sum_yy = 0;
    const double end = binned ? x[order[i]] + width : x[order[i]];
    std::size_t n = 0;
    for (; i < order.size() && x[order[i]] <= end; ++i, ++n) {
      sum_x += x[order[i]];
      sum_y += y[order[i]];
      sum_yy += y[order[i]] * y[order[i]];
    }
    const double count = static_cast<double>(n);
    xs.push_back(sum_x / count);
    ys.push_back(sum_y / count);
    counts.push_back(count);
    scatter_ += std::max(0.0, sum_yy - sum_y * sum_y / count);
    extra_ += count - 1;
  }
  const auto size = static_cast<Eigen::Index>(xs.size());
  x_ = Eigen::Map<Eigen::VectorXd>(xs.data(), size);
  y_ = Eigen::Map<Eigen::VectorXd>(ys.data(), size);
  count_ = Eigen::Map<Eigen::VectorXd>(counts.data(), size);
  square_.resize(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    square_.col(i) = (x_.array() - x_[i]).square().matrix();
  }
}

double GaussianProcess::logLikelihood(const Eigen::Vector3d& log_hyper,
                                      Eigen::Vector3d* gradient) const {
  const Eigen::Vector3d hyper = log_hyper.array().exp().matrix();
  const double signal = hyper[0], length = hyper[1], noise = hyper[2];
  const Eigen::VectorXd noise_variance = factor_ * noise * noise * count_.cwiseInverse();
  const Eigen::MatrixXd K = covariance(square_, noise_variance, signal, length);
  const Eigen::LLT<Eigen::MatrixXd> llt(K);
  if (llt.info() != Eigen::Success) return -1e12;
  const Eigen::Index n = x_.size();
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(n);
  const Eigen::VectorXd Kinv_ones = llt.solve(ones);
  const double mean = Kinv_ones.dot(y_) / Kinv_ones.sum();
  const Eigen::VectorXd alpha = llt.solve(y_ - mean * ones);
  const double log_det = 2 * llt.matrixLLT().diagonal().array().log().sum();
  // Second line: the scatter within the bins, which knows the noise only.
  const double value = -0.5 * (y_ - mean * ones).dot(alpha) - 0.5 * log_det -
                       0.5 * static_cast<double>(n) * std::log(2 * kPi) -
                       0.5 * scatter_ / (noise * noise) - extra_ * std::log(noise);
  if (!gradient) return value;
  // d/dtheta = 1/2 tr((alpha alpha^T - K^-1) dK/dtheta); the mean is optimal, so its change does
  // not count.
  const Eigen::MatrixXd A =
      alpha * alpha.transpose() - llt.solve(Eigen::MatrixXd::Identity(n, n)).eval();
  Eigen::MatrixXd S = K;
  S.diagonal() -= noise_variance;
  (*gradient)[0] = (A.array() * S.array()).sum();
  (*gradient)[1] = 0.5 * (A.array() * S.array() * square_.array()).sum() / (length * length);
  (*gradient)[2] = A.diagonal().dot(noise_variance) + scatter_ / (noise * noise) - extra_;
  return value;
}

void GaussianProcess::optimise(double min_noise) {
  const double mean = y_.mean();
  const double span = std::max(highest_ - lowest_, 1e-6);
  const double total = (count_.array() * (y_.array() - mean).square()).sum() + scatter_;
  const double spread =
      std::max(std::sqrt(total / std::max(count_.sum() - 1, 1.0)), 10 * min_noise);
  const std::vector<double> low = {std::log(1e-3 * spread), std::log(0.02 * span),
                                   std::log(min_noise)};
  const std::vector<double> high = {std::log(20 * spread), std::log(5 * span),
                                    std::log(3 * spread)};
  Objective objective{this, {std::log(spread), std::log(span), std::log(spread)}, -1e300};
  for (const double length : {0.08, 0.25, 0.8}) {
    for (const double noise : {0.2, 0.8}) {
      nlopt::opt opt(nlopt::LD_LBFGS, 3);
      opt.set_max_objective(evaluate, &objective);
      opt.set_lower_bounds(low);
      opt.set_upper_bounds(high);
      opt.set_ftol_abs(1e-4);
      opt.set_maxeval(kEvaluations);
      std::vector<double> theta = {std::log(0.7 * spread), std::log(length * span),
                                   std::log(noise * spread)};
      for (std::size_t k = 0; k < 3; ++k) theta[k] = std::clamp(theta[k], low[k], high[k]);
      double value = 0;
      try {
        opt.optimize(theta, value);
      } catch (const std::runtime_error&) {
        // Limited by rounding: the best point so far is kept by the objective.
      }
    }
  }
  hyper_.signal = std::exp(objective.best[0]);
  hyper_.length = std::exp(objective.best[1]);
  hyper_.noise = std::exp(objective.best[2]);
  hyper_.log_likelihood = objective.best_value;
}

void GaussianProcess::prepare() {
  const Eigen::VectorXd noise_variance =
      factor_ * hyper_.noise * hyper_.noise * count_.cwiseInverse();
  const Eigen::MatrixXd K = covariance(square_, noise_variance, hyper_.signal, hyper_.length);
  const Eigen::LLT<Eigen::MatrixXd> llt(K);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(x_.size());
  const Eigen::VectorXd Kinv_ones = llt.solve(ones);
  hyper_.mean = Kinv_ones.dot(y_) / Kinv_ones.sum();
  alpha_ = llt.solve(y_ - hyper_.mean * ones);
  chol_ = llt.matrixL();
}

GaussianProcess::Prediction GaussianProcess::predict(double x) const {
  const double s2 = hyper_.signal * hyper_.signal;
  const Eigen::VectorXd k =
      s2 * (-0.5 / (hyper_.length * hyper_.length) * (x_.array() - x).square()).exp().matrix();
  const auto L = chol_.triangularView<Eigen::Lower>();
  const Eigen::VectorXd v = L.solve(k);
  const Eigen::VectorXd w = L.solve(Eigen::VectorXd::Ones(x_.size()));
  // The mean is estimated too, which adds to the variance far from the samples.
  const double open = 1 - w.dot(v);
  const double variance = s2 - v.squaredNorm() + open * open / w.squaredNorm();
  return {hyper_.mean + k.dot(alpha_), std::sqrt(std::max(variance, 0.0))};
}

}  // namespace vir::ranging
