#pragma once
#include "evidence_cost.h"

namespace vir::team {

/// BOBYQA (NLopt) on the exact cost, from `x` with first steps `step`; the best point seen is kept,
/// never a worse one. Returns the cost. The descent by Gauss-Newton leaves out how the filter's
/// gains depend on the transform and may end a little beside the minimum.
double polish(const EvidenceCost& cost, Vec4* x, const Vec4& step, int evaluations);

}  // namespace vir::team
