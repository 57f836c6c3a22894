#pragma once
/// Other robots in `vir-slam run`.
#include <memory>
#include <string>
#include <vector>

#include "output/console.h"
#include "robots/peer_tracking.h"
#include "robots/rendezvous_options.h"
#include "vir/core/settings.h"

namespace vir::app {

/// Section [Rendezvous] of a run, and the estimator that follows other robots if it is to.
class PeerRun {
 public:
  /// Plugins must have been loaded. Throws SettingsError.
  void prepare(const Settings& settings);
  /// Declares what is read here. Without the rendezvous plugin the section is passed over, unless
  /// it is in the settings: then createRendezvous() throws PluginError.
  void describe(SettingsReader& reader) const;
  void describe(OptionVisitor& used) const;
  /// Wraps `estimator`, or hands it back where nobody is to be followed.
  std::unique_ptr<roles::Estimator> follow(std::unique_ptr<roles::Estimator> estimator);
  /// Results of the estimator that follow() gave, while it exists.
  void write(const results::ResultsFolder& folder) const;

 private:
  Settings settings_;
  RendezvousRunOptions options_;
  bool available_ = false;
  const PeerTracking* tracking_ = nullptr;
};

void addPeerRows(const std::vector<roles::PeerResult>& peers, std::vector<TableRow>* rows);

}  // namespace vir::app
