#pragma once
/// Tables of ranges as streams, one for each of the robot's antennas.
#include <vector>

#include "euroc_options.h"
#include "recording.h"

namespace vir::euroc {

/// A table whose column `antenna` (or `tag`) names several gives a stream, with a label of its own,
/// for each of them, unless one is asked for (EurocOptions::antenna). `T_B_I`: as in ImuYaml. `log`
/// hears of every row once, `silent` of the further readings; both, and `names`, must outlive the
/// streams.
std::vector<RangeStream> openRangeFiles(const std::vector<RangeFiles>& files, const EurocOptions& o,
                                        const Pose& T_B_I, tables::AnchorNames* names,
                                        ProblemLog* log, ProblemLog* silent);

/// Passes over what is not of the stream's antenna.
void skipOtherAntennas(RangeStream* stream, ProblemLog* log);

}  // namespace vir::euroc
