#pragma once
#include <string>
#include <vector>

#include "vir/evaluation/evaluate.h"

namespace vir::evaluation {

/// A comparison that went badly is made again under the mistakes that people make: attitudes
/// written in another order or the other way round, poses that are the inverse, another unit of
/// length, a clock that is off. What makes the errors at most a third is told, a line each; empty
/// where the comparison is good or nothing helps. `result` is that of evaluate() with `options`.
std::vector<std::string> likelyMistakes(const Trajectory& reference, const Trajectory& estimate,
                                        const EvaluationOptions& options,
                                        const EvaluationResult& result);

}  // namespace vir::evaluation
