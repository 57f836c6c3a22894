#pragma once
/// Role "rendezvous": mutual ranges with both robots' states in, the transform between their worlds
/// out.
#include "vir/core/log.h"
#include "vir/core/options.h"
#include "vir/team/find_transform.h"

namespace vir::roles {

/// One object per pair of robots, A and B.
class Rendezvous {
 public:
  virtual ~Rendezvous() = default;
  /// Declares the settings; called before start().
  virtual void describe(OptionVisitor& v) = 0;
  virtual void start(const LogSink& log) = 0;
  /// In order of time. Segments count up when a robot's estimator starts anew: another world.
  virtual void add(const team::MutualRange& range, int segment_A, int segment_B) = 0;
  /// All anchors that both robots know, as believed now; replaces what was set before.
  virtual void setAnchors(const std::vector<team::SharedAnchor>& anchors) = 0;
  /// p_A = T p_B from all that was added, valid at the newest range.
  virtual team::TransformAnswer answer() = 0;
};

}  // namespace vir::roles
