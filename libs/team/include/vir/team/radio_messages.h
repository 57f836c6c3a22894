#pragma once
/// The 60 bytes of peer_message.h by way of radios that carry data beside their ranges: what a
/// robot sends, and what becomes of the bytes that come in.
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vir/team/peer_inbox.h"
#include "vir/team/peer_message.h"
#include "vir/types/anchor.h"
#include "vir/types/state.h"

namespace vir::team {

/// The segment of a message holds the sender's session in its upper 10 bits, drawn at each start,
/// and its world in the lower 6: a robot that is started again is in another world.
constexpr int kWorldBits = 6;

/// Makes messages of what a robot estimates.
class RadioTeller {
 public:
  /// `robot`: its number, the id of its radio. `session`: any number; its lowest 10 bits count.
  /// `p_B_U`: antenna in the body [m].
  RadioTeller(std::uint16_t robot, std::uint32_t session, double rate_hz, const Vec3& p_B_U)
      : robot_(robot), session_(session), rate_hz_(rate_hz), p_B_U_(p_B_U) {}
  /// Empty: it is not time yet, or there is nothing that could be told (no pose, no number). With
  /// each one another anchor of `anchors` that is believed in.
  std::optional<PeerPacket> tell(const StateEstimate& estimate, const std::vector<Anchor>& anchors);

 private:
  std::optional<PeerAnchor> nextAnchor(const std::vector<Anchor>& anchors);

  std::uint16_t robot_;
  std::uint32_t session_;
  double rate_hz_;
  Vec3 p_B_U_;
  TimeNs due_ = 0;
  std::optional<int> segment_;
  std::uint16_t sequence_ = 0;
  std::uint32_t worlds_ = 0;
  std::size_t anchor_ = 0;
};

/// Messages out of the data that other radios have sent. They may come in pieces, several at once,
/// and among other things: each is found by its first byte and its checksum. Memory is bounded
/// whatever comes in.
class RadioInbox {
 public:
  /// `own_number`: of this robot; empty: not known.
  RadioInbox(std::optional<std::uint16_t> own_number, LogSink log);
  /// Data of radio `sender`, which is also the number of the robot that carries it. `now`: on the
  /// clock that the robots share. `arrival_s`: on any clock that only goes forward.
  std::vector<HeardReport> add(std::int64_t sender, const std::uint8_t* bytes, std::size_t size,
                               TimeNs now, double arrival_s);
  /// The connection was interrupted: what was begun is forgotten.
  void forgetHalfMessages() { pieces_.clear(); }
  /// All that is not 0, by name: "accepted" and why others are not.
  std::vector<std::pair<std::string, long>> counters() const;

 private:
  struct Pieces {
    std::vector<std::uint8_t> bytes;
    double last_s = 0;
    bool lost = false;  // what came last was no message
    std::uint32_t session = 0, sequence = 0;
    bool heard = false;
  };
  void search(std::int64_t sender, Pieces* pieces, TimeNs now, double arrival_s,
              std::vector<HeardReport>* out);
  void drop(std::size_t count, Pieces* pieces);

  PeerInbox inbox_;
  std::map<std::int64_t, Pieces> pieces_;
  long damaged_ = 0, foreign_bytes_ = 0, other_version_ = 0, other_sender_ = 0, too_many_ = 0;
};

}  // namespace vir::team
