#include "nlopt_rendezvous.h"

namespace vir {

void NloptRendezvous::start(const LogSink& log) {
  log_ = log;
  tracker_ = team::TransformTracker(options_);
}

void NloptRendezvous::add(const team::MutualRange& range, int segment_A, int segment_B) {
  const int before = tracker_.restarts();
  tracker_.add(range, segment_A, segment_B);
  if (tracker_.restarts() == before) return;
  log(log_, LogLevel::warning,
      "a robot started a new world: the transform between the two is being found anew");
}

void NloptRendezvous::setAnchors(const std::vector<team::SharedAnchor>& anchors) {
  tracker_.setAnchors(anchors);
}

void NloptRendezvous::setPlaces(const std::optional<SharedPlaces>& places) {
  tracker_.setPlaces(places);
}

void NloptRendezvous::moveA(const team::WorldTransform& T_new_A) { tracker_.moveA(T_new_A); }

team::TransformAnswer NloptRendezvous::answer() { return tracker_.answer(); }

}  // namespace vir
