#pragma once
/// What somebody who moves the robot can do about what the estimator says.
#include <string>
#include <vector>

#include "vir/types/anchor.h"
#include "vir/types/state.h"

namespace vir::results {

/// For a state that is starting, doubtful or lost: "move sideways, or up and down; turning alone
/// does not do". Empty where nothing needs to be done or nobody knows what.
std::string adviceFor(const StateEstimate& estimate);

/// Of anchors that are not found yet, the first one's with its id: "anchor 3: move further: ...";
/// "no ranges yet" for none at all. Empty where all are found.
std::string adviceFor(const std::vector<Anchor>& anchors);

}  // namespace vir::results
