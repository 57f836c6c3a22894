#include "pair_rendezvous.h"

#include <algorithm>
#include <cmath>

namespace vir::app {
namespace {

constexpr TimeNs kSameStamp = 2000000;  // a range and the broadcast that came with it
constexpr double kSameRange = 1e-4;     // [m]; recordings keep ranges as float
constexpr double kNearMirror = 1.0;     // [m]; closer together, two mirror images are one anchor

/// The newest entry within a stamp's rounding of `t`.
const SentPosition* sentAt(const std::vector<SentPosition>& list, TimeNs t) {
  const auto next =
      std::lower_bound(list.begin(), list.end(), t - kSameStamp,
                       [](const SentPosition& s, TimeNs stamp) { return s.t < stamp; });
  return next != list.end() && next->t <= t + kSameStamp ? &*next : nullptr;
}

struct AntennaState {
  Vec3 p_W = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
  int segment = 0;
};

std::optional<AntennaState> ownState(const RobotRecord& robot, TimeNs t, const Vec3& p_B_U) {
  const auto pose = robot.at(t);
  if (!pose) return std::nullopt;
  return AntennaState{pose->T_W_B * p_B_U, pose->covariance.topLeftCorner<3, 3>(), pose->segment};
}

/// Lever arm of a robot's antenna, as its own recording says it.
Vec3 leverOf(const RobotRecord& robot) {
  return robot.peer_ranges.empty() ? Vec3(Vec3::Zero()) : robot.peer_ranges.front().p_B_U;
}

std::optional<AntennaState> peerState(const RobotRecord& listener, const RobotRecord& peer,
                                      TimeNs t) {
  const auto heard = listener.heard.find(peer.id);
  const auto own = ownState(peer, t, leverOf(peer));
  if (heard == listener.heard.end()) return own;
  const SentPosition* sent = sentAt(heard->second, t);
  if (sent == nullptr) return std::nullopt;
  return AntennaState{sent->p_W, sent->covariance, own ? own->segment : 0};
}

void addRanges(const RobotRecord& listener, const RobotRecord& peer, bool listener_is_A,
               MutualRanges* out) {
  for (const PeerObservation& o : listener.peer_ranges) {
    if (o.peer != peer.id) continue;
    const auto own = ownState(listener, o.t, o.p_B_U);
    const auto other = peerState(listener, peer, o.t);
    if (!own || !other) {
      ++out->without_state;
      continue;
    }
    const AntennaState& a = listener_is_A ? *own : *other;
    const AntennaState& b = listener_is_A ? *other : *own;
    MutualObservation m;
    m.range = {o.t, o.range_m, o.sigma_m, a.p_W, b.p_W, a.covariance, b.covariance};
    m.segment_A = a.segment;
    m.segment_B = b.segment;
    out->list.push_back(m);
  }
}

/// What a robot believes of an anchor; empty if it is not to be relied on.
std::optional<SentPosition> believed(const AnchorEstimate& a) {
  if (!a.has_position || !a.p_W.allFinite() || !a.covariance.allFinite()) return std::nullopt;
  SentPosition out{0, a.p_W, a.covariance};
  if (a.state == "mirror_open") {
    const Vec3 apart = a.mirror_p_W - a.p_W;
    if (!(apart.norm() < kNearMirror)) return std::nullopt;
    out.covariance += apart * apart.transpose();
  } else if (a.state != "estimated" && a.state != "fixed") {
    return std::nullopt;
  }
  return out;
}

/// What `listener` last heard or, where nothing is recorded, what `peer` itself believed.
std::optional<SentPosition> peersAnchor(const RobotRecord& listener, const RobotRecord& peer,
                                        std::uint64_t id, TimeNs t) {
  if (listener.heard.count(peer.id) > 0) {
    const auto heard = listener.heard_anchors.find({peer.id, id});
    if (heard == listener.heard_anchors.end()) return std::nullopt;
    const auto& list = heard->second;
    const auto next =
        std::upper_bound(list.begin(), list.end(), t + kSameStamp,
                         [](TimeNs stamp, const SentPosition& s) { return stamp < s.t; });
    if (next == list.begin()) return std::nullopt;
    return *(next - 1);
  }
  for (const AnchorEstimate& a : peer.anchorsAt(t)) {
    if (a.id == id) return believed(a);
  }
  return std::nullopt;
}

}  // namespace

MutualRanges mutualRanges(const RobotRecord& a, const RobotRecord& b) {
  MutualRanges out;
  addRanges(a, b, true, &out);
  const std::size_t from_a = out.list.size();
  addRanges(b, a, false, &out);
  const auto before = [](const MutualObservation& x, const MutualObservation& y) {
    return x.range.t < y.range.t;
  };
  std::inplace_merge(out.list.begin(), out.list.begin() + static_cast<long>(from_a), out.list.end(),
                     before);
  std::vector<MutualObservation> kept;
  for (const MutualObservation& m : out.list) {
    const bool again = !kept.empty() && m.range.t - kept.back().range.t <= kSameStamp &&
                       std::abs(m.range.range_m - kept.back().range.range_m) < kSameRange;
    if (again) {
      ++out.doubled;
    } else {
      kept.push_back(m);
    }
  }
  out.list = std::move(kept);
  return out;
}

std::vector<SharedAnchor> sharedAnchors(const RobotRecord& a, const RobotRecord& b, TimeNs t) {
  std::vector<SharedAnchor> out;
  for (const AnchorEstimate& own : a.anchorsAt(t)) {
    const auto in_A = believed(own);
    const auto in_B = peersAnchor(a, b, own.id, t);
    if (!in_A || !in_B) continue;
    out.push_back({own.id, in_A->p_W, in_B->p_W, in_A->covariance, in_B->covariance});
  }
  return out;
}

PairResult playPair(const RobotRecord& a, const RobotRecord& b, Rendezvous* solver,
                    double interval_s, bool use_anchors) {
  PairResult out;
  out.transform.from = b.name;
  out.transform.to = a.name;
  out.ranges = mutualRanges(a, b);
  const auto& list = out.ranges.list;
  if (list.empty()) {
    out.transform.answer = solver->answer();
    return out;
  }
  const TimeNs first = list.front().range.t;
  TimeNs due = first;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const TimeNs t = list[i].range.t;
    solver->add(list[i].range, list[i].segment_A, list[i].segment_B);
    if (t < due && i + 1 < list.size()) continue;
    due = t + fromSeconds(interval_s);
    if (use_anchors) solver->setAnchors(sharedAnchors(a, b, t));
    PairMoment moment{toSeconds(t - first), solver->answer()};
    if (moment.answer.status == TransformStatus::unique && !out.transform.first_unique_s) {
      out.transform.first_unique_s = moment.since_first_s;
    }
    out.history.push_back(std::move(moment));
  }
  out.transform.answer = out.history.back().answer;
  return out;
}

}  // namespace vir::app
