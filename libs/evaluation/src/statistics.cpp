#include <algorithm>
#include <cmath>

#include "vir/evaluation/evaluate.h"

namespace vir::evaluation {
namespace {

double percentile(const std::vector<double>& sorted, double share) {
  const double x = share * static_cast<double>(sorted.size() - 1);
  const std::size_t i = static_cast<std::size_t>(x);
  const std::size_t j = std::min(i + 1, sorted.size() - 1);
  return sorted[i] + (x - static_cast<double>(i)) * (sorted[j] - sorted[i]);
}

}  // namespace

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
  s.median = percentile(errors, 0.5);
  s.p95 = percentile(errors, 0.95);
  s.max = errors.back();
  return s;
}

}  // namespace vir::evaluation
