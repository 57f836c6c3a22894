#pragma once
/// Other robots in `vir-slam run` and `vir-slam record`.
#include <memory>
#include <string>
#include <vector>

#include "output/console.h"
#include "robots/peer_follower.h"
#include "robots/rendezvous_options.h"
#include "vir/core/settings.h"

namespace vir::app {

/// Section [Rendezvous] of a run, and the observer that follows other robots if they are to be
/// followed.
class PeerRun {
 public:
  /// Plugins must have been loaded. Throws SettingsError.
  void prepare(const Settings& settings);
  /// Declares what is read here. Without the rendezvous plugin the section is passed over, unless
  /// it is in the settings: then createRendezvous() throws PluginError.
  void describe(SettingsReader& reader) const;
  void describe(OptionVisitor& used) const;
  /// Adds the observer that follows the others; nothing where nobody is to be followed. It belongs
  /// to this object. `listener` (may be empty) is told of them all the time.
  void follow(const LogSink& log, std::vector<results::RunObserver*>* observers,
              PeerListener listener = {});
  const std::string& label() const { return options_.peer_label; }
  /// Results of what follow() added.
  void write(const results::ResultsFolder& folder) const;

 private:
  Settings settings_;
  RendezvousRunOptions options_;
  bool available_ = false;
  std::unique_ptr<PeerFollower> follower_;
};

void addPeerRows(const std::vector<team::PeerResult>& peers, std::vector<TableRow>* rows);

}  // namespace vir::app
