#include "vir/team/pairing.h"

#include <algorithm>

namespace vir::team {
namespace {

struct AntennaState {
  Vec3 p_W = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
  int segment = 0;
  Vec3 p_B_U = Vec3::Zero();
  bool unknown = false;
};

/// Where the antenna was; the body's origin if nobody knows where on the robot it is.
std::optional<AntennaState> antennaState(const RobotRecord& robot, TimeNs t,
                                         const std::optional<Vec3>& p_B_U) {
  const auto pose = robot.at(t);
  if (!pose) return std::nullopt;
  AntennaState out;
  out.p_B_U = p_B_U.value_or(Vec3::Zero());
  out.p_W = pose->T_W_B * out.p_B_U;
  out.covariance = pose->covariance.topLeftCorner<3, 3>();
  out.segment = pose->segment;
  out.unknown = !p_B_U;
  if (out.unknown) {
    out.covariance += kUnknownAntennaSigma * kUnknownAntennaSigma * Mat3::Identity();
  }
  return out;
}

void addRanges(const RobotRecord& listener, const RobotRecord& peer, bool listener_is_A,
               MutualRanges* out) {
  for (const Range& r : listener.peer_ranges) {
    if (robotOf(r) != peer.id) continue;
    const auto own = antennaState(listener, r.t, r.p_B_U);
    const auto other = antennaState(peer, r.t, peer.antenna());
    if (!own || !other) {
      ++out->without_state;
      continue;
    }
    const AntennaState& a = listener_is_A ? *own : *other;
    const AntennaState& b = listener_is_A ? *other : *own;
    MutualObservation m;
    m.range = {r.t, r.range_m, r.sigma_m, a.p_W, b.p_W, a.covariance, b.covariance};
    m.segment_A = a.segment;
    m.segment_B = b.segment;
    m.antenna_A = a.p_B_U;
    m.antenna_B = b.p_B_U;
    m.antenna_unknown = other->unknown;
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
    const bool again = !kept.empty() && isSameRange(m.range.t, m.range.range_m, kept.back().range.t,
                                                    kept.back().range.range_m);
    if (again) {
      ++out.doubled;
    } else {
      out.antenna_unknown += m.antenna_unknown ? 1 : 0;
      kept.push_back(m);
    }
  }
  out.list = std::move(kept);
  return out;
}

std::vector<SharedAnchor> sharedAnchors(const RobotRecord& a, const RobotRecord& b, TimeNs t) {
  std::vector<SharedAnchor> out;
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

PairResult playPair(const RobotRecord& a, const RobotRecord& b, PairSolver* solver,
                    const PairOptions& options, const std::optional<SharedPlaces>& places) {
  PairResult out;
  out.transform.from = b.name;
  out.transform.to = a.name;
  out.ranges = mutualRanges(a, b);
  const auto& list = out.ranges.list;
  out.places = places;
  if (list.empty()) {
    solver->setPlaces(places);
    out.transform.answer = solver->answer();
    return out;
  }
  const TimeNs first = list.front().range.t;
  TimeNs due = first;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const TimeNs t = list[i].range.t;
    solver->add(list[i].range, list[i].segment_A, list[i].segment_B);
    if (t < due && i + 1 < list.size()) continue;
    due = t + fromSeconds(options.interval_s);
    if (places && (t >= places->since || i + 1 == list.size())) solver->setPlaces(places);
    if (options.use_anchors) solver->setAnchors(sharedAnchors(a, b, t));
    PairMoment moment{toSeconds(t - first), solver->answer()};
    if (moment.answer.status == TransformStatus::unique && !out.transform.first_unique_s) {
      out.transform.first_unique_s = moment.since_first_s;
    }
    out.history.push_back(std::move(moment));
  }
  out.transform.answer = out.history.back().answer;
  return out;
}

}  // namespace vir::team
