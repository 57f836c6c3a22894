#include "nlopt_polish.h"

#include <nlopt.hpp>

namespace vir::team {
namespace {

struct Best {
  const EvidenceCost* cost;
  double value;
  Vec4 x;
};

double objective(unsigned, const double* p, double*, void* data) {
  auto* best = static_cast<Best*>(data);
  const Vec4 x(p[0], p[1], p[2], p[3]);
  const double value = (*best->cost)(x);
  if (value < best->value) {
    best->value = value;
    best->x = x;
  }
  return value;
}

}  // namespace

double polish(const EvidenceCost& cost, Vec4* x, const Vec4& step, int evaluations) {
  Best best{&cost, cost(*x), *x};
  nlopt::opt bobyqa(nlopt::LN_BOBYQA, 4);
  bobyqa.set_min_objective(objective, &best);
  bobyqa.set_initial_step(std::vector<double>{step[0], step[1], step[2], step[3]});
  bobyqa.set_ftol_abs(1e-4);
  bobyqa.set_maxeval(evaluations);
  std::vector<double> p{(*x)[0], (*x)[1], (*x)[2], (*x)[3]};
  double value = 0;
  try {
    bobyqa.optimize(p, value);
  } catch (const std::exception&) {
    // It ends in rounding errors at times; the best point seen counts.
  }
  *x = best.x;
  return best.value;
}

}  // namespace vir::team
