#pragma once
/// Regression of a smooth function of one variable, with its uncertainty.
#include <Eigen/Core>
#include <vector>

namespace vir::ranging {

struct GaussianProcessOptions {
  int max_points = 120;  ///< more samples are gathered in so many bins; cost goes with its cube
  /// Variance of a mean of n samples is this times noise^2/n: above 1 where samples resemble one
  /// another (RangeCorrelation::correlation_factor).
  double correlation_factor = 1;
  double min_noise = 1e-4;  ///< in units of y
};

/// Constant mean, squared-exponential covariance s^2 exp(-(x-x')^2 / (2 l^2)), white noise. The
/// hyper-parameters maximise the marginal likelihood; samples that share a bin enter with their
/// number and their scatter, so that nothing is lost but detail within a bin.
class GaussianProcess {
 public:
  struct Hyper {
    double mean = 0;
    double signal = 0;  ///< s, in units of y
    double length = 1;  ///< l, in units of x
    double noise = 0;   ///< standard deviation of one sample
    double log_likelihood = 0;
  };
  struct Prediction {
    double mean = 0;
    double sigma = 0;  ///< of the function, without the noise of a sample
  };

  /// Throws std::invalid_argument for fewer than 3 samples, sizes that differ or values that are
  /// not finite. Deterministic.
  GaussianProcess(const std::vector<double>& x, const std::vector<double>& y,
                  const GaussianProcessOptions& options = {});

  Prediction predict(double x) const;
  const Hyper& hyper() const { return hyper_; }
  /// Where the samples lie.
  double lowest() const { return lowest_; }
  double highest() const { return highest_; }

  /// Log marginal likelihood with the best constant mean, and its gradient with respect to
  /// log(signal), log(length), log(noise), for tests and the optimiser.
  double logLikelihood(const Eigen::Vector3d& log_hyper, Eigen::Vector3d* gradient) const;

 private:
  void gather(const std::vector<double>& x, const std::vector<double>& y, int max_points);
  void optimise(double min_noise);
  void prepare();

  Eigen::VectorXd x_, y_, count_;   // bins
  Eigen::MatrixXd square_;          // (x_i - x_j)^2
  double scatter_ = 0, extra_ = 0;  // sum of squares within bins, and their degrees of freedom
  double factor_ = 1, lowest_ = 0, highest_ = 0;
  Hyper hyper_;
  Eigen::VectorXd alpha_;  // K^-1 (y - mean)
  Eigen::MatrixXd chol_;   // lower Cholesky factor of K
};

}  // namespace vir::ranging
