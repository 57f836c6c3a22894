#include "robots/peer_tracking.h"

#include <algorithm>
#include <cstdio>

#include "output/rendezvous_output.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/results/run_recorder.h"

namespace vir::app {
namespace {

constexpr TimeNs kBroadcastDelay = 200000000;  // it may come later than its range
constexpr TimeNs kLongestWait = 2000000000;    // for an own pose behind the range
constexpr std::size_t kKept = 400;             // of the newest own poses, and broadcasts of a robot
constexpr std::size_t kMostPeers = 32, kMostAnchors = 256;
// A robot that moves faster than this, and by more than its own uncertainty, began a new world.
constexpr double kFastest = 30, kJump = 1;  // [m/s], [m]

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

std::string placed(const roles::PeerResult& peer, const team::TransformSolution& s) {
  const Eigen::Vector4d sigma = s.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  char text[200];
  std::snprintf(text, sizeof text,
                "robot %d is placed after %.1f s: yaw %.1f +- %.1f deg, offset %.2f %.2f %.2f +- "
                "%.2f %.2f %.2f m",
                peer.id, peer.transform.first_unique_s.value_or(0), s.T_A_B.yaw_rad * 180 / M_PI,
                sigma[0] * 180 / M_PI, s.T_A_B.t_m.x(), s.T_A_B.t_m.y(), s.T_A_B.t_m.z(), sigma[1],
                sigma[2], sigma[3]);
  return text;
}

}  // namespace

PeerTracking::Peer* PeerTracking::peerOf(int id) {
  const auto known = peers_.find(id);
  if (known != peers_.end()) return &known->second;
  if (peers_.size() >= kMostPeers) return nullptr;
  Peer& peer = peers_[id];
  peer.solver = create_solver_();
  peer.solver->start([log = log_, id](LogLevel level, const std::string& text) {
    vir::log(log, level, "robot " + std::to_string(id) + ": " + text);
  });
  peer.result.id = id;
  peer.result.transform.from = std::to_string(id);
  peer.result.transform.to = kThisRobot;
  peer.result.transform.answer.reason = "no mutual range with a broadcast yet";
  return &peer;
}

void PeerTracking::hear(const PeerBroadcast& broadcast) {
  Peer* peer = peerOf(broadcast.peer);
  if (peer == nullptr) return;
  const SentPosition& sent = broadcast.sent;
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
    const double expected = kJump + kFastest * toSeconds(sent.t - before.t) +
                            4 * std::sqrt(std::max(0.0, sent.covariance.trace()));
    if ((sent.p_W - before.p_W).norm() > expected) {
      const int segment = peer->new_worlds.empty() ? 1 : peer->new_worlds.back().second + 1;
      peer->new_worlds.emplace_back(sent.t, segment);
      peer->anchors.clear();
    }
  }
  peer->heard.push_back(sent);
  trim(&peer->heard);
}

void PeerTracking::onObservation(const mrpt::obs::CObservation& observation) {
  // Only labels are looked at where no robot is ranged to.
  now_ = std::max(now_, rawlog::fromMrptTime(observation.timestamp));
  const std::string& label = observation.sensorLabel;
  if (label.compare(0, options_.peer_label.size(), options_.peer_label) == 0) {
    for (const PeerObservation& r : peerRangesOf(observation, options_.peer_label)) {
      if (Peer* peer = peerOf(r.peer)) {
        ++peer->result.ranges;
        waiting_.push_back(r);
      } else {
        ++too_many_;
      }
    }
    const auto broadcast = broadcastOf(observation, options_.peer_label, &unusable_);
    if (broadcast) hear(*broadcast);
  }
}

void PeerTracking::keepPose(const StateEstimate& e) {
  if (!e.valid || !e.state.T_W_B.p.allFinite() || !e.state.T_W_B.q.coeffs().allFinite()) return;
  if (!poses_.empty() && e.state.t <= poses_.back().t) return;
  poses_.push_back({e.state.t, e.state.T_W_B, e.covariance, e.segment});
  trim(&poses_);
}

void PeerTracking::onOutput(const roles::EstimatorOutput& output,
                            const roles::Estimator& estimator) {
  for (const StateEstimate& e : output.states) keepPose(e);
  useWaiting(estimator);
}

void PeerTracking::useWaiting(const roles::Estimator& estimator) {
  std::size_t done = 0;
  while (done < waiting_.size() && useOrCount(waiting_[done], estimator)) ++done;
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<long>(done));
}

bool PeerTracking::useOrCount(const PeerObservation& range, const roles::Estimator& estimator) {
  Peer& peer = peers_.at(range.peer);
  const bool behind = !poses_.empty() && poses_.back().t >= range.t;
  if (!behind && !finished_ && now_ < range.t + kLongestWait) return false;
  const SentPosition* sent = sentAt(peer.heard, range.t);
  if (sent == nullptr && !finished_ && now_ < range.t + kBroadcastDelay) return false;
  const auto own = poseAt(poses_, range.t);
  if (sent == nullptr) {
    ++peer.result.without_broadcast;
  } else if (!own) {
    ++peer.result.without_pose;
  } else {
    use(range, *own, *sent, estimator, &peer);
  }
  return true;
}

void PeerTracking::use(const PeerObservation& range, const KnownPose& own, const SentPosition& sent,
                       const roles::Estimator& estimator, Peer* peer) {
  int segment = 0;
  for (const auto& [from, number] : peer->new_worlds) {
    if (sent.t >= from) segment = number;
  }
  const Vec3 antenna = own.T_W_B * range.p_B_U;
  peer->solver->add({range.t, range.range_m, range.sigma_m, antenna, sent.p_W,
                     own.covariance.topLeftCorner<3, 3>(), sent.covariance},
                    own.segment, segment);
  if (peer->last == 0) peer->first = peer->due = range.t;
  peer->last = range.t;
  peer->asked = false;
  if (range.t >= peer->due) ask(estimator, peer);
}

void PeerTracking::ask(const roles::Estimator& estimator, Peer* peer) {
  peer->asked = true;
  peer->due = peer->last + fromSeconds(options_.interval_s);
  if (options_.use_anchors) {
    std::vector<team::SharedAnchor> shared;
    for (const Anchor& a : estimator.anchors()) {
      const auto own = believed(a);
      const auto other = peer->anchors.find(a.id);
      if (!own || other == peer->anchors.end()) continue;
      shared.push_back(
          {a.id, own->p_W, other->second.p_W, own->covariance, other->second.covariance});
    }
    peer->solver->setAnchors(shared);
  }
  team::PairTransform& t = peer->result.transform;
  const bool was_unique = t.answer.status == team::TransformStatus::unique;
  t.answer = peer->solver->answer();
  const bool is_unique = t.answer.status == team::TransformStatus::unique;
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
}

std::vector<roles::PeerResult> PeerTracking::peers() const {
  std::vector<roles::PeerResult> out;
  for (const auto& [id, peer] : peers_) {
    if (peer.result.ranges > 0) out.push_back(peer.result);  // the others were only overheard
  }
  return out;
}

void PeerTracking::onEnd(const roles::Estimator& estimator, results::RunSummary* summary) {
  finished_ = true;
  useWaiting(estimator);
  for (auto& [id, peer] : peers_) {
    if (!peer.asked) ask(estimator, &peer);
  }
  summary->peers = peers();
  if (peers_.empty() && unusable_ == 0) return;
  long ranges = 0, without_broadcast = 0, without_pose = 0;
  for (const auto& [id, peer] : peers_) {
    const roles::PeerResult& r = peer.result;
    ranges += r.ranges;
    without_broadcast += r.without_broadcast;
    without_pose += r.without_pose;
    if (r.without_broadcast == 0) continue;
    summary->warnings.push_back(
        std::to_string(r.without_broadcast) + " of " + std::to_string(r.ranges) +
        " ranges to robot " + std::to_string(id) + " came without its position (" +
        options_.peer_label + ":" + std::to_string(id) + " with the range's stamp): not used");
  }
  const auto count = [&](const char* name, long n) { summary->counters.emplace_back(name, n); };
  count("peer_ranges", ranges);
  count("peer_ranges_without_broadcast", without_broadcast);
  count("peer_ranges_without_pose", without_pose);
  if (unusable_ > 0) count("peer_broadcasts_unusable", unusable_);
  if (too_many_ > 0) count("peer_ranges_of_too_many_robots", too_many_);
}

void PeerTracking::write(const results::ResultsFolder& folder) const {
  std::vector<team::PairTransform> transforms;
  std::vector<PairResult> pairs;
  for (const auto& [id, peer] : peers_) {
    if (peer.result.ranges == 0) continue;
    transforms.push_back(peer.result.transform);
    pairs.push_back({peer.result.transform, peer.history, {}});
  }
  if (pairs.empty()) return;
  results::writeTextFile(folder.file("transforms.json"),
                         results::transformsJson(transforms, {}, kThisRobot));
  writeHistory(folder, pairs);
}

}  // namespace vir::app
