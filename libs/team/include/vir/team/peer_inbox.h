#pragma once
/// What of the reports that come in over a network can be believed.
#include <array>
#include <bitset>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vir/core/log.h"
#include "vir/team/peer_report.h"

namespace vir::team {

enum class ReportDecision {
  accepted,
  other_version,   ///< of the report
  own_number,      ///< it says that it comes from this robot
  not_finite,      ///< a number that is none, or an attitude that is no rotation
  absurd,          ///< farther or less sure than any robot is, or a covariance that is none
  other_clock,     ///< of the future, or this robot has no time yet
  late,            ///< nothing waits for it any more
  repeated,        ///< heard before
  old_world,       ///< of a world that its sender has left
  same_number,     ///< while another robot of this number is heard
  too_many_robots  ///< beyond 32
};
constexpr std::size_t kReportDecisions = 11;
const char* name(ReportDecision decision);

/// What a report amounts to for this robot.
struct HeardReport {
  WorldId world;
  PeerPose pose;
  std::vector<PeerBroadcast> anchors;
  std::vector<Range>
      ranges;  ///< that the sender has measured to this robot; `anchor` is the sender
  std::optional<TeamTold> team;
};

/// Decides about every report, counts all that are refused and says what is wrong once per robot.
/// Memory is bounded whatever comes in.
class PeerInbox {
 public:
  PeerInbox(std::uint32_t own_number, LogSink log)
      : own_number_(own_number), log_(std::move(log)) {}

  /// `own_time`: the newest stamp of this robot's own sensors; empty: there is none yet.
  /// `arrival_s`: on any clock that only goes forward.
  std::optional<HeardReport> add(const PeerReport& report, std::optional<TimeNs> own_time,
                                 double arrival_s);
  long count(ReportDecision decision) const { return counts_[static_cast<std::size_t>(decision)]; }
  /// Those that were sent before another one and came after it (they are accepted), and sequence
  /// numbers that never came.
  long reordered() const { return reordered_; }
  long lost() const { return lost_; }
  /// All that is not 0, by name.
  std::vector<std::pair<std::string, long>> counters() const;

 private:
  static constexpr std::size_t kWindow = 256;  // of sequence numbers
  struct Sender {
    std::uint64_t session = 0;
    std::uint32_t segment = 0;
    int world = 0;
    std::uint32_t newest = 0;  // sequence number
    std::bitset<kWindow> seen;
    double heard_s = 0;
    std::array<std::uint64_t, 8> left{};  // sessions
    std::size_t left_count = 0;
    bool told_number = false;
  };
  ReportDecision decide(const PeerReport& report, std::optional<TimeNs> own_time, double arrival_s);
  ReportDecision decideSender(const PeerReport& report, double arrival_s);
  ReportDecision decideSequence(const PeerReport& report, Sender* sender);
  void tell(const PeerReport& report, ReportDecision decision, std::optional<TimeNs> own_time);

  std::uint32_t own_number_;
  LogSink log_;
  std::map<std::uint32_t, Sender> senders_;
  std::array<long, kReportDecisions> counts_{};
  long reordered_ = 0, lost_ = 0;
  bool told_own_number_ = false, told_version_ = false, told_clock_ = false;
};

}  // namespace vir::team
