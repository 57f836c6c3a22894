#pragma once
/// The transform that lays an estimate onto its reference before errors are taken.
#include <string>
#include <vector>

#include "vir/evaluation/association.h"

namespace vir::evaluation {

/// `posyaw`: translation and rotation about z, what visual-inertial odometry cannot know.
/// `se3`, `sim3`: rigid, and rigid with scale (Umeyama 1991). `none`: worlds are the same.
enum class Alignment { none, posyaw, se3, sim3 };

/// False for a word that is none of "none posyaw se3 sim3".
bool parseAlignment(const std::string& word, Alignment* alignment);
const char* name(Alignment alignment);

/// p_R = scale * R * p_E + t, from the world of the estimate (E) to that of the reference (R).
struct AlignmentResult {
  Pose T_R_E;
  double scale = 1;
  /// Why part of the transform was not determined by the positions, else empty. What is left open
  /// then is taken from the attitudes (rotation) or 1 (scale): never NaN.
  std::string note;

  Pose apply(const Pose& T_E_B) const {
    return {(T_R_E.q * T_E_B.q).normalized(), scale * (T_R_E.q * T_E_B.p) + T_R_E.p};
  }
};

/// Minimises the sum of squared position errors in closed form. Throws std::invalid_argument when
/// `pairs` is empty and `kind` is not none.
AlignmentResult align(const std::vector<PosePair>& pairs, Alignment kind);

}  // namespace vir::evaluation
