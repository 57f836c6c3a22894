#include "robots/peer_run.h"

#include <algorithm>
#include <utility>

#include "vir/core/angles.h"
#include "vir/roles/rendezvous_registry.h"

namespace vir::app {
namespace {

constexpr const char* kSection = "Rendezvous";

}  // namespace

void PeerRun::prepare(const Settings& settings) {
  settings_ = settings;
  SettingsReader own(settings);
  vir::app::describe(own, options_);
  const auto all = roles::registeredRendezvous();
  // Who asks for a solver is told if there is none; who does not need not have one.
  available_ = settings.hasSection(kSection) ||
               std::any_of(all.begin(), all.end(), [&](const roles::RendezvousEntry& e) {
                 return e.name == options_.driver;
               });
}

void PeerRun::describe(SettingsReader& reader) const {
  if (!available_) return reader.ignoreSection(kSection);
  describe(static_cast<OptionVisitor&>(reader));
}

void PeerRun::describe(OptionVisitor& used) const {
  if (!available_) return;
  RendezvousRunOptions options = options_;
  vir::app::describe(used, options);
  const auto solver = roles::createRendezvous(options_.driver);
  SettingsReader own(settings_);
  solver->describe(own);
  solver->describe(used);
}

void PeerRun::follow(const LogSink& log, std::vector<results::RunObserver*>* observers,
                     PeerListener listener) {
  if (!available_ || !options_.in_run) return;
  const auto create_solver = [this](const LogSink& solver_log) {
    auto solver = roles::createRendezvous(options_.driver);
    SettingsReader reader(settings_);
    solver->describe(reader);
    solver->start(solver_log);
    return solver;
  };
  follower_ = std::make_unique<PeerFollower>(options_, create_solver, log);
  follower_->setListener(std::move(listener));
  observers->push_back(follower_.get());
}

void PeerRun::write(const results::ResultsFolder& folder) const {
  if (follower_) follower_->write(folder);
}

void addPeerRows(const std::vector<team::PeerResult>& peers, std::vector<TableRow>* rows) {
  for (const team::PeerResult& peer : peers) {
    const team::PairTransform& t = peer.transform;
    rows->push_back({"robot " + std::to_string(peer.id), name(t.answer.status), ""});
    if (!t.answer.reason.empty()) rows->push_back({"  why", t.answer.reason, ""});
    if (t.answer.status == team::TransformStatus::unique) {
      const team::TransformSolution& s = t.answer.solutions[0];
      const Eigen::Vector4d sigma = s.covariance.diagonal().cwiseMax(0).cwiseSqrt();
      const Vec3& p = s.T_A_B.t_m;
      rows->push_back(
          {"  yaw of its world",
           fixed(s.T_A_B.yaw_rad * 180 / kPi, 2) + " +- " + fixed(sigma[0] * 180 / kPi, 2), "deg"});
      rows->push_back(
          {"  offset", fixed(p.x(), 3) + " " + fixed(p.y(), 3) + " " + fixed(p.z(), 3), "m"});
      rows->push_back({"    standard deviation",
                       fixed(sigma[1], 3) + " " + fixed(sigma[2], 3) + " " + fixed(sigma[3], 3),
                       "m"});
    }
    rows->push_back(
        {"  first unique after", t.first_unique_s ? fixed(*t.first_unique_s, 1) : "-", "s"});
    rows->push_back({"  ranges, without its broadcast",
                     std::to_string(peer.ranges) + ", " + std::to_string(peer.without_broadcast),
                     ""});
  }
}

}  // namespace vir::app
