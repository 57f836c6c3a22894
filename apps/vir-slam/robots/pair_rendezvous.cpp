#include "robots/pair_rendezvous.h"

#include <algorithm>
#include <cmath>

namespace vir::app {
namespace {

constexpr double kSameRange = 1e-4;  // [m]; recordings keep ranges as float

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

void addRanges(const RobotRecord& listener, const RobotRecord& peer, bool listener_is_A,
               MutualRanges* out) {
  for (const PeerObservation& o : listener.peer_ranges) {
    if (o.peer != peer.id) continue;
    const auto own = ownState(listener, o.t, o.p_B_U);
    const auto other = ownState(peer, o.t, leverOf(peer));
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

std::vector<team::SharedAnchor> sharedAnchors(const RobotRecord& a, const RobotRecord& b,
                                              TimeNs t) {
  std::vector<team::SharedAnchor> out;
  for (const Anchor& own : a.anchorsAt(t)) {
    const auto in_A = believed(own);
    if (!in_A) continue;
    for (const Anchor& other : b.anchorsAt(t)) {
      const auto in_B = other.id == own.id ? believed(other) : std::nullopt;
      if (!in_B) continue;
      out.push_back({own.id, in_A->p_W, in_B->p_W, in_A->covariance, in_B->covariance});
    }
  }
  return out;
}

PairResult playPair(const RobotRecord& a, const RobotRecord& b, roles::Rendezvous* solver,
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
    if (moment.answer.status == team::TransformStatus::unique && !out.transform.first_unique_s) {
      out.transform.first_unique_s = moment.since_first_s;
    }
    out.history.push_back(std::move(moment));
  }
  out.transform.answer = out.history.back().answer;
  return out;
}

}  // namespace vir::app
