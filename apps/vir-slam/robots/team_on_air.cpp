#include "robots/team_on_air.h"

#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>
#include <random>

#include "live/program_module.h"
#include "vir/core/host_clock.h"
#include "vir/core/resource_usage.h"
#include "vir/core/time_bounds.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/results/run_recorder.h"
#include "vir/team/robot_record.h"

namespace vir::app {
namespace {

constexpr TimeNs kAnchorsEvery = 1'000'000'000;
constexpr double kLongestPause = 1;        // [s] in which the own time goes on without a sensor
constexpr std::size_t kMostWaiting = 512;  // ranges, until there is a pose of their time

std::unique_ptr<dds::Link> open(const dds::LinkOptions& options, const LogSink& log) {
  const auto open_link = reinterpret_cast<dds::OpenLink>(functionOfDds("virOpenDdsLink"));
  return std::unique_ptr<dds::Link>(open_link(options, log));
}

std::uint64_t newSession() {
  std::random_device random;
  return (static_cast<std::uint64_t>(random()) << 32) | random();
}

}  // namespace

TeamOnAir::TeamOnAir(const dds::LinkOptions& options, std::string peer_label, LogSink log)
    : options_(options),
      peer_label_(std::move(peer_label)),
      log_(std::move(log)),
      link_(open(options, log_)),
      inbox_(static_cast<std::uint32_t>(options.robot), log_) {
  next_.robot = static_cast<std::uint32_t>(options.robot);
  next_.session = newSession();
}

void TeamOnAir::note(const std::vector<live::Arrival>& own) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const live::Arrival& a : own) {
    // Of sensors rather than of states: these are late where a computer has too much to do.
    const TimeNs t = rawlog::fromMrptTime(a.observation->timestamp);
    if (isStamp(t) && (!newest_ || t > *newest_)) {
      newest_ = t;
      newest_at_s_ = wallSeconds();
    }
    for (const Range& r : rawlog::rangesOf(*a.observation)) {
      p_B_U_ = r.p_B_U;  // one radio does both
      if (a.observation->sensorLabel != peer_label_) continue;
      if (ranges_.size() >= kMostWaiting) {
        ranges_.erase(ranges_.begin());
        ++ranges_untold_;
      }
      ranges_.push_back(r);
    }
  }
}

std::optional<TimeNs> TeamOnAir::ownTime() const {
  if (!newest_) return std::nullopt;
  return *newest_ + fromSeconds(std::min(kLongestPause, wallSeconds() - newest_at_s_));
}

std::vector<live::Arrival> TeamOnAir::receive(std::size_t source) {
  std::vector<live::Arrival> out;
  const std::vector<team::PeerReport> reports = link_->take();
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const team::PeerReport& r : reports) {
    const auto heard = inbox_.add(r, ownTime(), wallSeconds());
    if (!heard) continue;
    append(*heard, source, &out);
    if (heard->team) mapper_.hear(heard->world, r.t, *heard->team);
    HeardWorld& world = worlds_[r.robot];
    if (!(world.id == heard->world) || heard->pose.t > world.pose.t) {
      world = {heard->world, heard->pose};
    }
  }
  return out;
}

void TeamOnAir::append(const team::HeardReport& heard, std::size_t source,
                       std::vector<live::Arrival>* arrivals) const {
  const TimeNs now = hostNow();
  arrivals->push_back({source, rawlog::toObservation(heard.pose, peer_label_), now});
  for (const PeerBroadcast& anchor : heard.anchors) {
    arrivals->push_back({source, rawlog::toObservation(anchor, peer_label_), now});
  }
  for (Range range : heard.ranges) {
    range.p_B_U = p_B_U_;  // this robot answered
    arrivals->push_back(
        {source, rawlog::toObservation(range, peer_label_, rawlog::kUnknownRadio), now});
  }
}

void TeamOnAir::onOutput(const roles::EstimatorOutput& output, const roles::Estimator& estimator) {
  // For the others a frame is a world as a segment is: what was told of the one before is of no
  // use.
  if (!output.frame_changes.empty()) {
    frames_ += static_cast<std::uint32_t>(output.frame_changes.size());
    transforms_.clear();
  }
  for (const StateEstimate& e : output.states) {
    if (!e.valid || (e.state.t < due_ && due_ - e.state.t < kAnchorsEvery)) continue;
    const auto period = fromSeconds(1 / options_.rate_hz);
    due_ = e.state.t - due_ < period ? due_ + period : e.state.t + period;
    tell(e, estimator);
  }
}

void TeamOnAir::onPeers(const std::vector<team::PeerResult>& peers) {
  transforms_.clear();
  for (const team::PeerResult& p : peers) {
    const team::TransformAnswer& answer = p.transform.answer;
    if (answer.status != team::TransformStatus::unique || !p.told) continue;
    const team::TransformSolution& s = answer.solutions[0];
    transforms_[p.id] = {p.told->segment, s.T_A_B, s.covariance};
  }
}

/// Who is where, from this robot's pairs and what the others have told of theirs.
void TeamOnAir::mapTeam(const StateEstimate& own) {
  const TimeNs t = own.state.t;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<team::ToldTransform> transforms;
    for (const auto& [id, one] : transforms_) {
      const auto w = worlds_.find(static_cast<std::uint32_t>(id));
      // Of a world that it has left there is nothing to tell.
      if (w == worlds_.end() || w->second.pose.world != one.world) continue;
      transforms.push_back({w->second.id, one.T_own_from, one.covariance});
    }
    mapper_.setOwn({next_.robot, next_.session, next_.segment}, t, std::move(transforms));
    mapper_.solve(t);
    next_.team = mapper_.told();
    state_ = {t, next_.robot, mapper_.frame(), {}, mapper_.leftOut()};
    for (const auto& [robot, place] : mapper_.places()) {
      RobotPlace& out = state_.robots.emplace_back();
      out.id = robot;
      out.place = place;
      const auto w = worlds_.find(robot);
      if (robot == next_.robot) {
        out.told = StampedPose{t, place.T_C_world.pose() * own.state.T_W_B};
      } else if (w != worlds_.end() && w->second.id == place.world) {
        out.told = StampedPose{w->second.pose.t, place.T_C_world.pose() * w->second.pose.T_W_B};
      }
    }
  }
  if (listener_) listener_(state_);
}

void TeamOnAir::write(const results::ResultsFolder& folder) const {
  results::writeTextFile(folder.file("team.json"), teamJson(state_));
}

void TeamOnAir::tell(const StateEstimate& e, const roles::Estimator& estimator) {
  team::PeerReport& r = next_;
  r.t = e.state.t;
  r.T_W_B = e.state.T_W_B;
  r.covariance = e.covariance;
  r.segment = static_cast<std::uint32_t>(e.segment) + frames_;
  r.anchors.clear();
  r.team.reset();
  if (r.t >= anchors_due_ || anchors_due_ - r.t > kAnchorsEvery) {
    anchors_due_ = r.t + kAnchorsEvery;
    for (const Anchor& a : estimator.anchors()) {
      if (const auto sent = team::believed(a)) r.anchors.emplace_back(a.id, *sent);
    }
    mapTeam(e);
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    r.p_B_U = p_B_U_;
    // Others judge a range by the pose that it came with: one of now waits for the pose behind it.
    auto behind = std::stable_partition(ranges_.begin(), ranges_.end(),
                                        [&](const Range& range) { return range.t <= r.t; });
    // The rest with the next one.
    if (ranges_.size() > team::kMostReportedRanges) {
      behind = std::min(behind, ranges_.begin() + static_cast<long>(team::kMostReportedRanges));
    }
    r.ranges.assign(ranges_.begin(), behind);
    ranges_.erase(ranges_.begin(), behind);
  }
  link_->send(r);
  ++r.sequence;
}

std::vector<std::pair<std::string, long>> TeamOnAir::counters() const {
  std::vector<std::pair<std::string, long>> out = link_->counters();
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const auto& [name, count] : inbox_.counters()) out.emplace_back(name, count);
  if (ranges_untold_ > 0) out.emplace_back("ranges_untold", ranges_untold_);
  return out;
}

void TeamOnAir::onEnd(const roles::Estimator& /*estimator*/, results::RunSummary* summary) {
  for (const auto& [name, count] : counters())
    summary->counters.emplace_back("team_" + name, count);
}

std::string TeamOnAir::report() const {
  std::string line = "team on DDS domain " + std::to_string(options_.domain) + ", as robot " +
                     std::to_string(options_.robot) + ": " + std::to_string(link_->listeners()) +
                     " others listen";
  for (const auto& [name, count] : counters()) {
    if (count > 0) line += ", " + name + " " + std::to_string(count);
  }
  return line;
}

}  // namespace vir::app
