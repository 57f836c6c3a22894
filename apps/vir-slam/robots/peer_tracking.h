#pragma once
/// Keeps the transforms to other robots' worlds up to date while an estimator runs, from what came
/// over the air alone: own estimates, own ranges (`PEER`), and what the other robots broadcast with
/// them (`PEER:<id>`, `PEER:<id>:ANCHOR:<a>`).
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "robots/pair_rendezvous.h"
#include "robots/peer_observations.h"
#include "robots/rendezvous_options.h"
#include "vir/core/options.h"
#include "vir/results/results_folder.h"
#include "vir/results/run_observer.h"
#include "vir/roles/peer_result.h"
#include "vir/roles/rendezvous.h"

namespace vir::app {

/// Stands for the robot itself in transforms.json.
constexpr const char* kThisRobot = "this";

/// A solver with its settings read, not started.
using SolverFactory = std::function<std::unique_ptr<roles::Rendezvous>()>;

/// Follows the other robots of a run. What a range needs, it waits for: an own pose on either side
/// of it and the broadcast with its stamp. All that comes without is counted. Memory is bounded:
/// beside the transforms' history, of everything only the last seconds are kept.
class PeerTracking final : public results::RunObserver {
 public:
  PeerTracking(const RendezvousRunOptions& options, SolverFactory create_solver, LogSink log)
      : options_(options), create_solver_(std::move(create_solver)), log_(std::move(log)) {}

  void onObservation(const mrpt::obs::CObservation& observation) override;
  void onOutput(const roles::EstimatorOutput& output, const roles::Estimator& estimator) override;
  void onEnd(const roles::Estimator& estimator, results::RunSummary* summary) override;

  /// Other robots that were ranged to, ordered by id.
  std::vector<roles::PeerResult> peers() const;
  /// transforms.json and transforms_over_time.csv; nothing if no robot was ranged to.
  void write(const results::ResultsFolder& folder) const;

 private:
  struct Peer {
    std::unique_ptr<roles::Rendezvous> solver;
    std::vector<SentPosition> heard;                 ///< the last seconds, in order of time
    std::map<std::uint64_t, SentPosition> anchors;   ///< as last heard
    std::vector<std::pair<TimeNs, int>> new_worlds;  ///< from then on it is another segment
    TimeNs first = 0, due = 0, last = 0;             ///< of its ranges
    bool asked = true;                               ///< since the last range
    roles::PeerResult result;
    std::vector<PairMoment> history;
  };

  void hear(const PeerBroadcast& broadcast);
  void keepPose(const StateEstimate& estimate);
  void useWaiting(const roles::Estimator& estimator);
  /// False: what the range needs may still come.
  bool useOrCount(const PeerObservation& range, const roles::Estimator& estimator);
  void use(const PeerObservation& range, const KnownPose& own, const SentPosition& sent,
           const roles::Estimator& estimator, Peer* peer);
  void ask(const roles::Estimator& estimator, Peer* peer);
  Peer* peerOf(int id);

  RendezvousRunOptions options_;
  SolverFactory create_solver_;
  LogSink log_;
  std::map<int, Peer> peers_;
  std::vector<KnownPose> poses_;          ///< own, the last seconds
  std::vector<PeerObservation> waiting_;  ///< in order of time
  TimeNs now_ = 0;
  bool finished_ = false;
  long unusable_ = 0, too_many_ = 0;
};

}  // namespace vir::app
