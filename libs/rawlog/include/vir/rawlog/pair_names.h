#pragma once
#include <cstddef>
#include <map>
#include <string>

namespace vir::rawlog {

/// Labels of the two images of a pair.
struct PairLabels {
  std::string left, right;
};

/// What the images of pairs are called: of the first label of pairs `CAM0` and `CAM1`, of the next
/// one `CAM2` and `CAM3`, ... in the order in which they come; of a label `CAM<n>` that and
/// `CAM<n+1>`.
class PairNames {
 public:
  PairLabels of(const std::string& pair_label);

 private:
  std::map<std::string, PairLabels> known_;
  std::size_t given_ = 0;
};

}  // namespace vir::rawlog
