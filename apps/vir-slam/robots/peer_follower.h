#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "robots/rendezvous_options.h"
#include "vir/results/results_folder.h"
#include "vir/results/run_observer.h"
#include "vir/team/peer_tracker.h"

namespace vir::app {

/// Where all other robots are that this one has ranged to, as known at `t`.
using PeerListener = std::function<void(TimeNs t, const std::vector<team::PeerResult>& peers)>;

/// Tells a PeerTracker of a run: ranges to other robots (`PEER`) and what these broadcast with them
/// (`PEER:<id>`, `PEER:<id>:ANCHOR:<a>`) or at their own rate (`PEER:<id>:WORLD:<w>`).
class PeerFollower final : public results::RunObserver {
 public:
  PeerFollower(const RendezvousRunOptions& options, team::PairSolverFactory create_solver,
               LogSink log)
      : peer_label_(options.peer_label),
        interval_s_(options.interval_s),
        tracker_({options.interval_s, options.use_anchors, options.settled_interval_s},
                 std::move(create_solver), std::move(log)) {}

  void onObservation(const mrpt::obs::CObservation& observation) override;
  void onOutput(const roles::EstimatorOutput& output, const roles::Estimator& estimator) override;
  /// Called in onOutput(), every `interval_s` of the run's time.
  void setListener(PeerListener listener) { listener_ = std::move(listener); }
  void onEnd(const roles::Estimator& estimator, results::RunSummary* summary) override;

  /// transforms.json and transforms_over_time.csv; nothing if no robot was ranged to.
  void write(const results::ResultsFolder& folder) const;

 private:
  std::string peer_label_;
  double interval_s_;
  team::PeerTracker tracker_;
  PeerListener listener_;
  TimeNs told_ = 0;
};

}  // namespace vir::app
