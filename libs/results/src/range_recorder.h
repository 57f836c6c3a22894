#pragma once
/// anchors.csv and ranges.csv of a run.
#include <map>
#include <string>
#include <vector>

#include "vir/core/thinned_out.h"
#include "vir/results/results_folder.h"
#include "vir/roles/estimator.h"

namespace vir::results {

class RangeRecorder {
 public:
  /// Throws std::runtime_error if a file cannot be created.
  explicit RangeRecorder(const ResultsFolder& folder);

  /// One line of ranges.csv.
  void add(const RangeRecord& record);
  /// Writes anchors.csv and closes ranges.csv. Throws std::runtime_error if that fails.
  void finish(const std::vector<Anchor>& anchors);

  long accepted() const { return accepted_; }
  long collected() const { return collected_; }
  long rejected() const { return rejected_; }
  long beforeStart() const { return before_start_; }
  /// "ranges_accepted", "ranges_collected" and one for each reason a range was not used.
  std::vector<std::pair<std::string, long>> counters() const;
  /// What pictures show: evenly thinned out, at most twice kShown.
  const std::vector<RangeRecord>& sample() const { return sample_.values(); }

  static constexpr std::size_t kShown = 2000;

 private:
  const ResultsFolder& folder_;
  OutputFile file_;
  std::map<RangeDecision, long> decisions_;
  long accepted_ = 0, collected_ = 0, rejected_ = 0, before_start_ = 0;
  ThinnedOut<RangeRecord> sample_{kShown};
};

}  // namespace vir::results
