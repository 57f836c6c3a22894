#include "vir/alignment/transform_tracker.h"

#include <algorithm>

#include "vir/core/options.h"

namespace vir {

void describe(OptionVisitor& v, TransformTrackerOptions& o) {
  describe(v, o.transform);
  v.value("max_ranges", o.max_ranges, {20, 1000000},
          "ranges kept per pair; beyond, every second of the older half is dropped");
}

void TransformTracker::add(const MutualRange& range, int segment_A, int segment_B) {
  if (seen_ + old_ == 0) {
    segment_A_ = segment_A;
    segment_B_ = segment_B;
  }
  if (segment_A < segment_A_ || segment_B < segment_B_) {
    ++old_;
    return;
  }
  if (segment_A > segment_A_ || segment_B > segment_B_) {
    ranges_.clear();
    hints_.clear();
    anchors_.clear();
    segment_A_ = segment_A;
    segment_B_ = segment_B;
    seen_ = 0;
    ++restarts_;
  }
  ++seen_;
  ranges_.push_back(range);
  if (static_cast<int>(ranges_.size()) <= options_.max_ranges) return;
  std::vector<MutualRange> kept;
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    if (i % 2 == 0 || i > ranges_.size() / 2) kept.push_back(ranges_[i]);
  }
  ranges_ = std::move(kept);
}

TransformAnswer TransformTracker::answer() {
  TransformAnswer answer = findTransform(ranges_, anchors_, options_.transform, hints_);
  hints_.clear();
  for (const TransformSolution& s : answer.solutions) hints_.push_back(s.T_A_B);
  return answer;
}

}  // namespace vir
