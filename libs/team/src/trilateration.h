#pragma once
/// The offset between two worlds from ranges when the yaw is known.
#include <array>
#include <optional>
#include <vector>

#include "vir/team/world_transform.h"

namespace vir::team {

class Trilateration {
 public:
  /// All axes of the relative motion taken as known; the two mirror images at its plane; the ring
  /// around its line, sampled.
  static constexpr std::size_t kBranches = 7;

  explicit Trilateration(const std::vector<MutualRange>& ranges) : ranges_(ranges) {}

  /// Offsets t for p_A = Rz(yaw) p_B + t; empty where the motion needs no such branch.
  std::array<std::optional<Vec3>, kBranches> solve(double yaw_rad) const;

 private:
  const std::vector<MutualRange>& ranges_;
};

}  // namespace vir::team
