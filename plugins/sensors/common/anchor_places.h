#pragma once
/// Where anchors stand, as the ranges to them say it.
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "problem_log.h"
#include "vir/geometry/so3.h"
#include "vir/types/survey.h"

namespace vir {

/// Some radios tell the place of the anchor with each range. One that is always the same has been
/// measured by somebody; one that changes is that of an anchor that moves. Memory does not depend
/// on the number of ranges.
class AnchorPlaces {
 public:
  /// What the range says [m], in a frame of its own. Not finite, or 99999 and beyond (so write
  /// radios that do not know): not told.
  void add(std::uint64_t anchor, const Vec3& p_S);
  /// Those that are always at one place, within a millimetre, by id. None where all are at the
  /// origin: nobody has filled in the field.
  std::vector<SurveyedAnchor> standing() const;
  /// Notes which anchors move, and that nobody has filled in the places.
  void say(ProblemLog* log) const;

 private:
  struct Place {
    Vec3 first = Vec3::Zero();
    double farthest = 0;  ///< from the first [m]
  };
  bool anyFilledIn() const;

  std::map<std::uint64_t, Place> places_;
};

}  // namespace vir
