#include "robots/peer_follower.h"

#include "output/rendezvous_output.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/results/run_recorder.h"
#include "vir/results/transforms_json.h"

namespace vir::app {

void PeerFollower::onObservation(const mrpt::obs::CObservation& observation) {
  // Only labels are looked at where no robot is ranged to.
  tracker_.advance(rawlog::fromMrptTime(observation.timestamp));
  const std::string& label = observation.sensorLabel;
  if (label == peer_label_) {
    for (const Range& r : rawlog::rangesOf(observation)) tracker_.addRange(r);
  } else if (rawlog::isBroadcastLabel(label, peer_label_)) {
    if (const auto pose = rawlog::peerPoseOf(observation, peer_label_)) {
      tracker_.hear(*pose);
    } else if (const auto broadcast = rawlog::broadcastOf(observation, peer_label_)) {
      tracker_.hear(*broadcast);
    } else {
      tracker_.countUnusableBroadcast();
    }
  }
}

void PeerFollower::onOutput(const roles::EstimatorOutput& output,
                            const roles::Estimator& estimator) {
  auto change = output.frame_changes.begin();
  for (const StateEstimate& e : output.states) {
    for (; change != output.frame_changes.end() && change->t <= e.state.t; ++change) {
      tracker_.changeFrame(*change);
    }
    tracker_.addState(e);
  }
  for (; change != output.frame_changes.end(); ++change) tracker_.changeFrame(*change);
  tracker_.use([&] { return estimator.anchors(); });
  if (!listener_ || output.states.empty()) return;
  const TimeNs t = output.states.back().state.t;
  if (t < told_ + fromSeconds(interval_s_) && t >= told_) return;
  told_ = t;
  const std::vector<team::PeerResult> peers = tracker_.peers();
  if (!peers.empty()) listener_(t, peers);
}

void PeerFollower::onEnd(const roles::Estimator& estimator, results::RunSummary* summary) {
  tracker_.finish([&] { return estimator.anchors(); });
  summary->peers = tracker_.peers();
  if (!tracker_.met() && tracker_.unusableBroadcasts() == 0) return;
  long ranges = 0, without_broadcast = 0, without_pose = 0, doubled = 0;
  for (const team::PeerResult& r : summary->peers) {
    ranges += r.ranges;
    without_broadcast += r.without_broadcast;
    without_pose += r.without_pose;
    doubled += r.doubled;
    if (r.without_broadcast == 0) continue;
    const std::string id = std::to_string(r.id);
    summary->warnings.push_back(std::to_string(r.without_broadcast) + " of " +
                                std::to_string(r.ranges) + " ranges to robot " + id +
                                " came without its position (" + peer_label_ + ":" + id +
                                " with the range's stamp): not used");
  }
  const auto count = [&](const char* name, long n) { summary->counters.emplace_back(name, n); };
  count("peer_ranges", ranges);
  count("peer_ranges_without_broadcast", without_broadcast);
  count("peer_ranges_without_pose", without_pose);
  if (doubled > 0) count("peer_ranges_told_twice", doubled);
  if (const long n = tracker_.unusableBroadcasts(); n > 0) count("peer_broadcasts_unusable", n);
  if (const long n = tracker_.rangesOfTooManyRobots(); n > 0) {
    count("peer_ranges_of_too_many_robots", n);
  }
}

void PeerFollower::write(const results::ResultsFolder& folder) const {
  const std::vector<team::PairResult> pairs = tracker_.pairs();
  if (pairs.empty()) return;
  std::vector<team::PairTransform> transforms;
  for (const team::PairResult& p : pairs) transforms.push_back(p.transform);
  const team::MergedMap map = team::mapOf(team::solveTeam(team::kThisRobot, team::edgesOf(pairs)));
  results::writeTextFile(folder.file("transforms.json"), results::transformsJson(transforms, map));
  writeHistory(folder, pairs);
}

}  // namespace vir::app
