#pragma once
/// Which sensor of a rawlog a topic of our own MCAP files was.
#include <string>

#include "survey.h"
#include "vir/geometry/pose.h"

namespace vir::bag {

struct OwnLabel {
  std::string
      label;  ///< empty: the file does not say, or it is none that messages of the type have
  std::string anchor;           ///< what the anchor in `label` is called; empty: it is a number
  Vec3 antenna = Vec3::Zero();  ///< of another robot, in its body [m]
};

/// Of topics of ranges (to anchors, between robots, between anchors), and of what another robot
/// told or where an anchor was put down. Files of before, which hold no labels, are known by the
/// names of their topics.
OwnLabel ownLabelOf(const TopicInfo& info);
/// `label` with this number for its anchor; as it is if it names none.
std::string withAnchor(const std::string& label, std::uint64_t anchor);

}  // namespace vir::bag
