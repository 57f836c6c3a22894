#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "output/team_json.h"
#include "vir/dds/link.h"
#include "vir/live/acquisition.h"
#include "vir/results/results_folder.h"
#include "vir/results/run_observer.h"
#include "vir/team/peer_inbox.h"
#include "vir/team/peer_result.h"

namespace vir::app {

/// This robot among the others of its team: tells them where it is, what it believes of anchors and
/// what it has measured to them, and makes observations of what they tell, which are recorded and
/// followed as if they had come with the ranges.
class TeamOnAir final : public results::RunObserver {
 public:
  /// Opens the link. Throws std::runtime_error: the program was built without DDS, or what the link
  /// throws. `peer_label`: of ranges to other robots.
  TeamOnAir(const dds::LinkOptions& options, std::string peer_label, LogSink log);

  /// What this robot's own sensors have delivered. In the thread of receive().
  void note(const std::vector<live::Arrival>& own);
  /// What the others have told since the last call, as of sensor number `source`.
  std::vector<live::Arrival> receive(std::size_t source);

  /// Tells the others where this robot is. In the thread of the estimation.
  void onOutput(const roles::EstimatorOutput& output, const roles::Estimator& estimator) override;
  void onEnd(const roles::Estimator& estimator, results::RunSummary* summary) override;
  /// How the others' worlds lie in this one, as known at `t`. In the thread of the estimation.
  void onPeers(const std::vector<team::PeerResult>& peers);
  /// Called once per second, in the thread of the estimation.
  using MapListener = std::function<void(const TeamState& team)>;
  void setListener(MapListener listener) { listener_ = std::move(listener); }
  /// team.json: where everybody was in the end.
  void write(const results::ResultsFolder& folder) const;
  /// What was told and heard, a line.
  std::string report() const;

 private:
  struct HeardWorld {
    team::WorldId id;
    PeerPose pose;  // the newest; its `world` is the number under which pairs know this one
  };
  struct OwnTransform {
    int world = 0;
    team::WorldTransform T_own_from;
    Eigen::Matrix4d covariance;
  };
  void tell(const StateEstimate& estimate, const roles::Estimator& estimator);
  void mapTeam(const StateEstimate& own);
  void append(const team::HeardReport& heard, std::size_t source,
              std::vector<live::Arrival>* arrivals) const;
  std::optional<TimeNs> ownTime() const;
  std::vector<std::pair<std::string, long>> counters() const;

  const dds::LinkOptions options_;
  const std::string peer_label_;
  LogSink log_;
  std::unique_ptr<dds::Link> link_;
  mutable std::mutex mutex_;  // of what follows
  team::PeerInbox inbox_;
  team::TeamMapper mapper_;
  std::map<std::uint32_t, HeardWorld> worlds_;  // 32 at most, as the inbox lets in
  Vec3 p_B_U_ = Vec3::Zero();
  std::vector<Range> ranges_;  // of its own, to be told
  long ranges_untold_ = 0;
  std::optional<TimeNs> newest_;  // stamp of its own sensors
  double newest_at_s_ = 0;        // steady clock
  // Of the thread of the estimation:
  std::map<int, OwnTransform> transforms_;
  MapListener listener_;
  TeamState state_;
  std::uint32_t frames_ = 0;  // changed, as of maps
  team::PeerReport next_;
  TimeNs due_ = 0, anchors_due_ = 0;
};

}  // namespace vir::app
