#include "robots/rendezvous_options.h"

namespace vir::app {

void describe(OptionVisitor& v, RendezvousRunOptions& o) {
  v.section("Rendezvous", "How the transform between two robots' worlds is found");
  v.value("driver", o.driver, "Rendezvous plugin; `vir-slam plugins` lists them");
  v.value("peer_label", o.peer_label, "sensor label of the ranges to other robots");
  v.value("in_run", o.in_run,
          "`vir-slam run` finds the transforms to robots it ranges to, from what they broadcast");
  v.value("interval_s", o.interval_s, {0.01, 1e4}, "time between two answers of a pair");
  v.value("settled_interval_s", o.settled_interval_s, {0.01, 1e4},
          "the same in a run or live, once the pair's transform is unique");
  v.value("use_anchors", o.use_anchors, "use the anchors that both robots know");
  v.value(
      "use_places", o.use_places,
      "`vir-slam rendezvous` uses the places that both robots' images show, by the maps of their "
      "runs");
  v.value("joint", o.joint,
          "solve both recordings together in the end, where they hold odometry poses");
}

}  // namespace vir::app
