#include "vir/team/peer_tracker.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "moved_frame.h"
#include "thin_out.h"
#include "vir/core/angles.h"
#include "vir/geometry/finite_pose.h"

namespace vir::team {
namespace {

constexpr TimeNs kBroadcastDelay = 200000000;  // it may come later than its range
constexpr TimeNs kLongestWait = 2000000000;    // for an own pose behind the range
constexpr std::size_t kKept = 400;             // of the newest own poses, and broadcasts of a robot
constexpr double kFarthest = 1e8;              // [m] no robot is farther from where it began
constexpr std::size_t kMostPeers = 32, kMostAnchors = 256;
// A robot that moves faster than this, and by more than its own uncertainty, began a new world.
constexpr double kFastest = 30, kJump = 1;  // [m/s], [m]
constexpr std::size_t kRecent = 32;         // ranges of a robot that one may be told again of
// Between two poses of its own a robot may have left the straight line by this [m/s^2].
constexpr double kAcceleration = 1;

template <typename T>
void trim(std::vector<T>* list) {
  if (list->size() >= 2 * kKept) list->erase(list->begin(), list->end() - kKept);
}

const SentPosition* sentAt(const std::vector<SentPosition>& list, TimeNs t) {
  const auto next =
      std::lower_bound(list.begin(), list.end(), t - kSameStamp,
                       [](const SentPosition& s, TimeNs stamp) { return s.t < stamp; });
  return next != list.end() && next->t <= t + kSameStamp ? &*next : nullptr;
}

/// Farther than the robot can have come: its world is another one.
bool jumped(const SentPosition& before, const SentPosition& now) {
  const double expected = kJump + kFastest * toSeconds(now.t - before.t) +
                          4 * std::sqrt(std::max(0.0, now.covariance.trace()));
  return (now.p_W - before.p_W).norm() > expected;
}

std::string placed(const PeerResult& peer, const TransformSolution& s) {
  const Eigen::Vector4d sigma = s.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  char text[200];
  std::snprintf(text, sizeof text,
                "robot %d is placed after %.1f s: yaw %.1f +- %.1f deg, offset %.2f %.2f %.2f +- "
                "%.2f %.2f %.2f m",
                peer.id, peer.transform.first_unique_s.value_or(0), s.T_A_B.yaw_rad * 180 / kPi,
                sigma[0] * 180 / kPi, s.T_A_B.t_m.x(), s.T_A_B.t_m.y(), s.T_A_B.t_m.z(), sigma[1],
                sigma[2], sigma[3]);
  return text;
}

}  // namespace

PeerTracker::Peer* PeerTracker::peerOf(int id) {
  const auto known = peers_.find(id);
  if (known != peers_.end()) return &known->second;
  if (peers_.size() >= kMostPeers) return nullptr;
  Peer& peer = peers_[id];
  peer.solver = create_solver_([log = log_, id](LogLevel level, const std::string& text) {
    vir::log(log, level, "robot " + std::to_string(id) + ": " + text);
  });
  peer.result.id = id;
  peer.result.transform.from = std::to_string(id);
  peer.result.transform.to = kThisRobot;
  peer.result.transform.answer.reason = "no mutual range with a broadcast yet";
  return &peer;
}

void PeerTracker::advance(TimeNs t) { now_ = std::max(now_, t); }

void PeerTracker::addRange(const Range& peer_range) {
  Peer* peer = peerOf(robotOf(peer_range));
  if (peer == nullptr) {
    ++too_many_;
    return;
  }
  const bool again = std::any_of(peer->recent.begin(), peer->recent.end(), [&](const Range& r) {
    return isSameRange(r.t, r.range_m, peer_range.t, peer_range.range_m);
  });
  if (again) {
    ++peer->result.doubled;
    return;
  }
  if (peer->recent.size() >= kRecent) peer->recent.erase(peer->recent.begin());
  peer->recent.push_back(peer_range);
  ++peer->result.ranges;
  // What another robot has measured comes later than what was measured here.
  const auto behind = std::upper_bound(waiting_.begin(), waiting_.end(), peer_range.t,
                                       [](TimeNs t, const Range& r) { return t < r.t; });
  waiting_.insert(behind, peer_range);
}

void PeerTracker::hear(const PeerBroadcast& broadcast) {
  const SentPosition& sent = broadcast.sent;
  const bool far = !(sent.p_W.cwiseAbs().maxCoeff() < kFarthest) ||
                   !(sent.covariance.cwiseAbs().maxCoeff() < kFarthest * kFarthest);
  if (far || !sent.p_W.allFinite() || !sent.covariance.allFinite()) {
    ++unusable_;
    return;
  }
  Peer* peer = peerOf(broadcast.peer);
  if (peer == nullptr) return;
  if (broadcast.anchor) {
    const bool known = peer->anchors.count(*broadcast.anchor) > 0;
    if (!known && peer->anchors.size() >= kMostAnchors) {
      ++unusable_;
      return;
    }
    peer->anchors[*broadcast.anchor] = sent;
    return;
  }
  if (!peer->heard.empty()) {
    const SentPosition& before = peer->heard.back();
    if (sent.t <= before.t) return;
    if (jumped(before, sent)) {
      const int segment = peer->new_worlds.empty() ? 1 : peer->new_worlds.back().second + 1;
      peer->new_worlds.emplace_back(sent.t, segment);
      peer->anchors.clear();
    }
  }
  peer->heard.push_back(sent);
  trim(&peer->heard);
}

void PeerTracker::hear(const PeerPose& pose) {
  const Vec3& p = pose.T_W_B.p;
  if (!isFinite(pose.T_W_B) || !(p.cwiseAbs().maxCoeff() < kFarthest) ||
      !(pose.covariance.cwiseAbs().maxCoeff() < kFarthest * kFarthest) ||
      !(pose.p_B_U.cwiseAbs().maxCoeff() < kFarthest) || !pose.covariance.allFinite()) {
    ++unusable_;
    return;
  }
  Peer* peer = peerOf(pose.peer);
  if (peer == nullptr) return;
  std::vector<KnownPose>& path = peer->path;
  if (!path.empty() && pose.world < path.back().segment) return;
  if (!path.empty() && pose.world > path.back().segment) beginWorld(pose, peer);
  KnownPose known{pose.t, pose.T_W_B, {}, pose.world};
  known.covariance.setZero();
  known.covariance.topLeftCorner<3, 3>() = pose.covariance;
  const auto behind = std::lower_bound(path.begin(), path.end(), pose.t,
                                       [](const KnownPose& k, TimeNs t) { return k.t < t; });
  if (behind != path.end() && behind->t == pose.t) return;
  path.insert(behind, known);
  peer->p_B_U = pose.p_B_U;
  peer->result.told = path.back();
  trim(&path);
}

void PeerTracker::beginWorld(const PeerPose& pose, Peer* peer) {
  peer->path.clear();
  peer->anchors.clear();
  peer->due = peer->last;
  PairTransform& t = peer->result.transform;
  if (t.answer.status == TransformStatus::unique) {
    vir::log(log_, LogLevel::info,
             "robot " + std::to_string(pose.peer) + " began a new world: where that is is open");
  }
  t.answer = TransformAnswer();
  t.answer.reason = "it began a new world";
}

void PeerTracker::addState(const StateEstimate& estimate) {
  if (keepPose(estimate, &poses_)) trim(&poses_);
}

void PeerTracker::changeFrame(const FrameChange& change) {
  const WorldTransform T_new_own{yawOf(change.T_new_old.R()), change.T_new_old.p};
  for (KnownPose& pose : poses_) {
    if (pose.t < change.t) move(T_new_own, &pose);
  }
  for (auto& [id, peer] : peers_) {
    peer.solver->moveA(T_new_own);
    moveA(T_new_own, &peer.result.transform.answer);
    for (PairMoment& moment : peer.history) moveA(T_new_own, &moment.answer);
  }
}

void PeerTracker::use(const AnchorsNow& anchors) {
  std::size_t done = 0;
  while (done < waiting_.size() && useOrCount(waiting_[done], anchors)) ++done;
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<long>(done));
}

bool PeerTracker::useOrCount(const Range& range, const AnchorsNow& anchors) {
  Peer& peer = peers_.at(robotOf(range));
  const bool behind = !poses_.empty() && poses_.back().t >= range.t;
  if (!behind && !finished_ && now_ < range.t + kLongestWait) return false;
  const auto told = toldAt(peer, range.t);
  // The poses of a path are later than broadcasts by what an estimate takes, and the network.
  const TimeNs longest = peer.path.empty() ? kBroadcastDelay : kLongestWait;
  if (!told && !finished_ && now_ < range.t + longest) return false;
  const auto own = poseAt(poses_, range.t);
  if (!told) {
    ++peer.result.without_broadcast;
  } else if (!own) {
    ++peer.result.without_pose;
  } else {
    give(range, *own, *told, &peer);
    if (range.t >= peer.due) ask(anchors, &peer);
  }
  return true;
}

std::optional<PeerTracker::Told> PeerTracker::toldAt(const Peer& peer, TimeNs t) {
  if (!peer.path.empty()) {
    const auto pose = poseAt(peer.path, t);
    if (!pose) return std::nullopt;
    Told out{{t, pose->T_W_B * peer.p_B_U, pose->covariance.topLeftCorner<3, 3>()}, pose->segment};
    const auto next = std::lower_bound(peer.path.begin(), peer.path.end(), t,
                                       [](const KnownPose& k, TimeNs s) { return k.t < s; });
    if (next->t == t || next == peer.path.begin()) return out;
    const double before_s = toSeconds(t - (next - 1)->t), behind_s = toSeconds(next->t - t);
    const double off = 0.5 * kAcceleration * before_s * behind_s;
    out.sent.covariance += off * off * Mat3::Identity();
    return out;
  }
  const SentPosition* sent = sentAt(peer.heard, t);
  if (sent == nullptr) return std::nullopt;
  Told out{*sent, 0};
  for (const auto& [from, number] : peer.new_worlds) {
    if (sent->t >= from) out.world = number;
  }
  return out;
}

void PeerTracker::give(const Range& range, const KnownPose& own, const Told& told, Peer* peer) {
  const SentPosition& sent = told.sent;
  const Vec3 antenna = own.T_W_B * range.p_B_U;
  peer->solver->add({range.t, range.range_m, range.sigma_m, antenna, sent.p_W,
                     own.covariance.topLeftCorner<3, 3>(), sent.covariance},
                    own.segment, told.world);
  if (peer->last == 0) peer->first = peer->due = range.t;
  peer->last = std::max(peer->last, range.t);
  peer->asked = false;
}

void PeerTracker::ask(const AnchorsNow& anchors, Peer* peer) {
  peer->asked = true;
  if (options_.use_anchors) {
    std::vector<SharedAnchor> shared;
    for (const Anchor& a : anchors()) {
      const auto own = believed(a);
      const auto other = peer->anchors.find(a.id);
      if (!own || other == peer->anchors.end()) continue;
      shared.push_back(
          {a.id, own->p_W, other->second.p_W, own->covariance, other->second.covariance});
    }
    peer->solver->setAnchors(shared);
  }
  PairTransform& t = peer->result.transform;
  const bool was_unique = t.answer.status == TransformStatus::unique;
  t.answer = peer->solver->answer();
  const bool is_unique = t.answer.status == TransformStatus::unique;
  peer->due = peer->last +
              fromSeconds(is_unique ? std::max(options_.interval_s, options_.settled_interval_s)
                                    : options_.interval_s);
  const double since_first_s = toSeconds(peer->last - peer->first);
  if (is_unique && !t.first_unique_s) t.first_unique_s = since_first_s;
  if (is_unique && !was_unique) {
    vir::log(log_, LogLevel::info, placed(peer->result, t.answer.solutions[0]));
  } else if (was_unique && !is_unique) {
    vir::log(log_, LogLevel::info,
             "where robot " + std::to_string(peer->result.id) +
                 " is became open again: " + t.answer.reason);
  }
  peer->history.push_back({since_first_s, t.answer});
  thinOut(options_.max_moments, &peer->history);
}

void PeerTracker::finish(const AnchorsNow& anchors) {
  finished_ = true;
  use(anchors);
  for (auto& [id, peer] : peers_) {
    if (!peer.asked) ask(anchors, &peer);
  }
}

std::vector<PeerResult> PeerTracker::peers() const {
  std::vector<PeerResult> out;
  for (const auto& [id, peer] : peers_) {
    if (peer.result.ranges > 0) out.push_back(peer.result);
  }
  return out;
}

std::vector<PairResult> PeerTracker::pairs() const {
  std::vector<PairResult> out;
  for (const auto& [id, peer] : peers_) {
    if (peer.result.ranges > 0) out.push_back({peer.result.transform, peer.history, {}});
  }
  return out;
}

}  // namespace vir::team
