#pragma once
/// report.html of robots that met.
#include <string>
#include <vector>

#include "vir/team/meeting.h"

namespace vir::results {

struct MeetingPage {
  const team::Meeting& meeting;
  /// Page of each robot's own run, relative to this one; empty where there is none. In the order of
  /// the meeting's robots.
  std::vector<std::string> reports;
  std::string still_svg;  ///< shown where there is no script
};

/// One page without network: the robots in their common world and over time, and how each transform
/// became known. Robots that cannot be placed are named with the reason.
std::string meetingHtml(const MeetingPage& page);

}  // namespace vir::results
