#pragma once
/// The systematic error of a ranging device as a function of distance: b_d of the paper's
/// measurement model, measured = d + b_d(d) + noise, calibrated beforehand.
#include <stdexcept>
#include <string>
#include <vector>

namespace vir::ranging {

/// what(): `NAME:LINE: what is wrong; what is allowed`.
class RangeBiasModelError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A table over distance, smooth between its nodes (cubic, continuous slope). Without nodes: no
/// bias, known exactly.
class RangeBiasModel {
 public:
  struct Node {
    double distance_m = 0;
    double bias_m = 0;   ///< measured minus true
    double sigma_m = 0;  ///< how well that is known
  };
  struct Bias {
    double mean_m = 0;
    double sigma_m = 0;
    double slope = 0;  ///< d mean / d distance
  };

  RangeBiasModel() = default;
  /// Throws RangeBiasModelError unless distances ascend strictly from 0 or more, all is finite and
  /// no sigma negative. `noise_sigma_m`: of one range, as found by the calibration; 0 = not known.
  explicit RangeBiasModel(std::vector<Node> nodes, double noise_sigma_m = 0);

  /// At the true distance. Beyond the table the last value holds, and sigma grows by 2 cm per
  /// metre.
  Bias at(double distance_m) const;
  /// The true distance that a measured range stands for.
  double corrected(double measured_m) const;

  bool empty() const { return nodes_.empty(); }
  const std::vector<Node>& nodes() const { return nodes_; }

  /// csv with a line that names the format; reads back as the same numbers.
  std::string text() const;
  /// Strict: throws RangeBiasModelError naming `name` and the line for anything unexpected.
  static RangeBiasModel fromText(const std::string& text, const std::string& name = "bias model");

 private:
  double slopeAtNode(std::size_t i) const;
  std::vector<Node> nodes_;
  double noise_sigma_m_ = 0;
};

}  // namespace vir::ranging
