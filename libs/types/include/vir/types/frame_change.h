#pragma once
/// Poses that go on in another frame, as of a map in which a run was found.
#include "vir/core/time.h"
#include "vir/geometry/pose.h"

namespace vir {
inline namespace types {

/// From the state of time `t` on poses are in a new frame. Nothing has moved: those before are to
/// be seen there by `T_new_old`, a turn about the vertical and an offset [m].
struct FrameChange {
  TimeNs t = 0;
  Pose T_new_old;
};

}  // namespace types
}  // namespace vir
