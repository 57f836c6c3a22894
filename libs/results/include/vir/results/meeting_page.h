#pragma once
/// report.html of robots that met.
#include <cstddef>
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
  std::string command;    ///< that made it; may be empty
  /// What was said while it was made.
  std::vector<std::string> warnings, errors;
};

/// Number of the colour (evaluation::figureColor, c0.. of the page) of the i-th robot's path; that
/// of anchors and of their mirror images is none of them.
std::size_t robotColor(std::size_t i);
constexpr std::size_t kAnchorColor = 1;

/// One page without network: the robots in their common world and over time, and how each transform
/// became known. Robots that cannot be placed are named with the reason.
std::string meetingHtml(const MeetingPage& page);

}  // namespace vir::results
