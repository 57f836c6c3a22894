#include <algorithm>
#include <cmath>

#include "vir/core/order_statistics.h"
#include "vir/evaluation/evaluate.h"

namespace vir::evaluation {

Statistics statisticsOf(std::vector<double> errors) {
  Statistics s;
  s.count = static_cast<long>(errors.size());
  if (errors.empty()) return s;
  std::sort(errors.begin(), errors.end());
  double sum = 0, sum_sq = 0;
  for (const double e : errors) {
    sum += e;
    sum_sq += e * e;
  }
  const double n = static_cast<double>(errors.size());
  s.rmse = std::sqrt(sum_sq / n);
  s.mean = sum / n;
  s.median = quantileOfSorted(errors, 0.5);
  s.p95 = quantileOfSorted(errors, 0.95);
  s.max = errors.back();
  return s;
}

}  // namespace vir::evaluation
