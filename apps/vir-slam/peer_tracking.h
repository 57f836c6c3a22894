#pragma once
/// Keeps the transforms to other robots' worlds up to date while an estimator runs, from what came
/// over the air alone: own estimates, own ranges (`PEER`), and what the other robots broadcast with
/// them (`PEER:<id>`, `PEER:<id>:ANCHOR:<a>`).
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pair_rendezvous.h"
#include "peer_observations.h"
#include "rendezvous_options.h"
#include "vir/core/options.h"
#include "vir/pipeline/estimator.h"
#include "vir/pipeline/rendezvous.h"
#include "vir/pipeline/results_folder.h"

namespace vir::app {

/// Stands for the robot itself in transforms.json.
constexpr const char* kThisRobot = "this";

/// A solver with its settings read, not started.
using SolverFactory = std::function<std::unique_ptr<Rendezvous>()>;

/// Runs the estimator inside and follows the others. What a range needs, it waits for: an own pose
/// on either side of it and the broadcast with its stamp. All that comes without is counted. Memory
/// is bounded: beside the transforms' history, of everything only the last seconds are kept.
class PeerTracking final : public Estimator {
 public:
  PeerTracking(std::unique_ptr<Estimator> inner, const RendezvousRunOptions& options,
               SolverFactory create_solver)
      : inner_(std::move(inner)), options_(options), create_solver_(std::move(create_solver)) {}

  void describe(OptionVisitor& v) override { inner_->describe(v); }
  void start(const LogSink& log) override;
  void add(const mrpt::obs::CObservation& observation) override;
  void finish() override;
  std::vector<StateEstimate> take() override;
  std::vector<LandmarkEstimate> landmarks() const override { return inner_->landmarks(); }
  std::vector<KeyframeEstimate> keyframes() const override { return inner_->keyframes(); }
  std::vector<AnchorEstimate> anchors() const override { return inner_->anchors(); }
  std::vector<RangeRecord> takeRanges() override { return inner_->takeRanges(); }
  std::vector<PeerResult> peers() const override;
  EstimatorReport report() const override;

  /// transforms.json and transforms_over_time.csv; nothing if no robot was ranged to.
  void write(const ResultsFolder& folder) const;

 private:
  struct Peer {
    std::unique_ptr<Rendezvous> solver;
    std::vector<SentPosition> heard;                 ///< the last seconds, in order of time
    std::map<std::uint64_t, SentPosition> anchors;   ///< as last heard
    std::vector<std::pair<TimeNs, int>> new_worlds;  ///< from then on it is another segment
    TimeNs first = 0, due = 0, last = 0;             ///< of its ranges
    bool asked = true;                               ///< since the last range
    PeerResult result;
    std::vector<PairMoment> history;
  };

  void hear(const PeerBroadcast& broadcast);
  void keepPose(const StateEstimate& estimate);
  void resolve();
  /// False: what the range needs may still come.
  bool settle(const PeerObservation& range);
  void use(const PeerObservation& range, const KnownPose& own, const SentPosition& sent,
           Peer* peer);
  void ask(Peer* peer);
  Peer* peerOf(int id);

  std::unique_ptr<Estimator> inner_;
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
