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
#include "vir/roles/estimator.h"
#include "vir/roles/rendezvous.h"

namespace vir::app {

/// Stands for the robot itself in transforms.json.
constexpr const char* kThisRobot = "this";

/// A solver with its settings read, not started.
using SolverFactory = std::function<std::unique_ptr<roles::Rendezvous>()>;

/// Runs the estimator inside and follows the others. What a range needs, it waits for: an own pose
/// on either side of it and the broadcast with its stamp. All that comes without is counted. Memory
/// is bounded: beside the transforms' history, of everything only the last seconds are kept.
class PeerTracking final : public roles::Estimator {
 public:
  PeerTracking(std::unique_ptr<roles::Estimator> inner, const RendezvousRunOptions& options,
               SolverFactory create_solver)
      : inner_(std::move(inner)), options_(options), create_solver_(std::move(create_solver)) {}

  void describe(OptionVisitor& v) override { inner_->describe(v); }
  void start(const LogSink& log) override;
  void add(const mrpt::obs::CObservation& observation) override;
  void finish() override;
  std::vector<roles::StateEstimate> take() override;
  std::vector<roles::LandmarkEstimate> landmarks() const override { return inner_->landmarks(); }
  std::vector<roles::KeyframeEstimate> keyframes() const override { return inner_->keyframes(); }
  std::vector<roles::AnchorEstimate> anchors() const override { return inner_->anchors(); }
  std::vector<roles::RangeRecord> takeRanges() override { return inner_->takeRanges(); }
  std::vector<roles::PeerResult> peers() const override;
  roles::EstimatorReport report() const override;

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
  void keepPose(const roles::StateEstimate& estimate);
  void resolve();
  /// False: what the range needs may still come.
  bool settle(const PeerObservation& range);
  void use(const PeerObservation& range, const KnownPose& own, const SentPosition& sent,
           Peer* peer);
  void ask(Peer* peer);
  Peer* peerOf(int id);

  std::unique_ptr<roles::Estimator> inner_;
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
