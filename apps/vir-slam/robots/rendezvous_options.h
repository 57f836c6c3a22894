#pragma once
#include <string>

#include "vir/core/options.h"
#include "vir/rawlog/labels.h"

namespace vir::app {

/// What the program itself reads in [Rendezvous]; the plugin declares the rest.
struct RendezvousRunOptions {
  std::string driver = "nlopt";
  std::string peer_label = rawlog::kPeerLabel;
  bool in_run = true;
  double interval_s = 0.5, settled_interval_s = 2;
  bool use_anchors = true;
  bool use_places = true;
  bool joint = true;
};

void describe(OptionVisitor& v, RendezvousRunOptions& o);

}  // namespace vir::app
