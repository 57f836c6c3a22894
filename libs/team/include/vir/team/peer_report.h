#pragma once
/// What a robot tells the others over a network, where there is room for all of it.
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vir/team/robot_record.h"
#include "vir/team/team_mapper.h"
#include "vir/types/peer_broadcast.h"
#include "vir/types/range.h"

namespace vir::team {

constexpr int kPeerReportVersion = 1;
/// More are not told at once.
constexpr std::size_t kMostReportedAnchors = 64, kMostReportedRanges = 32;

struct PeerReport {
  int version = kPeerReportVersion;
  std::uint32_t robot = 0;     ///< who sends: the id under which others range to it
  std::uint64_t session = 0;   ///< drawn by its program at the start; another one is another world
  std::uint32_t segment = 0;   ///< of its world; another one is another world
  std::uint32_t sequence = 0;  ///< counts up by one per report of a session
  TimeNs t = 0;                ///< of the pose, on the clock that the robots share
  Pose T_W_B;                  ///< in its own world
  /// Of (position in W [m], rotation on the right [rad]).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  Vec3 p_B_U = Vec3::Zero();                                    ///< its antenna [m]
  std::vector<std::pair<std::uint64_t, SentPosition>> anchors;  ///< that it believes in, with ids
  std::vector<Range> ranges;     ///< that it has measured to other robots since the last report
  std::optional<TeamTold> team;  ///< of its world; not in every report
};

/// Reports of the team; nobody waits for anybody. Any thread.
class PeerLink {
 public:
  virtual ~PeerLink() = default;
  /// False: it could not be sent now.
  virtual bool send(const PeerReport& report) = 0;
  /// What has come in since the last call, the own ones left out; in order per sender, if the
  /// network kept it.
  virtual std::vector<PeerReport> take() = 0;
  /// How many others there are to hear a report at the moment.
  virtual int listeners() const = 0;
  /// What was sent, heard and refused by the transport itself, by name.
  virtual std::vector<std::pair<std::string, long>> counters() const = 0;
};

}  // namespace vir::team
