#pragma once
/// Internal: do the stamps of images scatter about the times at which they were taken?
#include <cstddef>
#include <deque>

namespace vir::estimator {

class StampJitter {
 public:
  /// An image was taken so much later than its stamp says, by the readings and what it shows [s].
  void add(double late_s);
  /// Standard deviation of the stamps [s]; 0 as long as it is not above what stamps that are right
  /// show.
  double sigma() const { return sigma_; }
  void reset() { *this = StampJitter(); }

 private:
  std::deque<double> late_;
  double sigma_ = 0;
};

}  // namespace vir::estimator
