#pragma once
/// Robust loss of a range residual. No line of sight only lengthens a range, so a measurement that
/// is too long gets the heavier tail.

namespace vir::ranging {

/// Loss of a whitened residual r = (measured - predicted) / sigma. For r < 0 the pseudo-Huber loss
/// of the paper, rho(q) = delta^2 (sqrt(1 + (q/delta)^2) - 1) (section "UWB Factor"); for r > 0 the
/// Cauchy loss, whose influence dies out. Both behave as r^2/2 at 0, where they join smoothly.
///
/// The two tails differ, so Gaussian noise shifts an estimate by about -0.1 sigma with the defaults
/// (the predicted range comes out too short); a bias in the state takes that up.
struct RobustRange {
  double huber_delta = 2.0;  ///< in sigma; <= 0: no robustification of ranges that are too short
  double nlos_delta = 1.5;   ///< in sigma; <= 0: no robustification of ranges that are too long

  struct Value {
    double e = 0;       ///< residual for Gauss-Newton: e^2/2 = rho(r), with the sign of r
    double de_dr = 1;   ///< its derivative
    double weight = 1;  ///< (e/r)^2, 1 at r = 0: how much of the squared residual is left
    /// rho'(r)/r, the weight of iteratively reweighted least squares.
    double influence() const;
  };

  /// Finite for every finite or infinite r; a NaN gives e = de_dr = weight = 0, so that it has no
  /// effect.
  Value evaluate(double r) const;
  /// rho(r) alone.
  double loss(double r) const;
};

}  // namespace vir::ranging
