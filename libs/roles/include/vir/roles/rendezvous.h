#pragma once
/// Role "rendezvous": mutual ranges with both robots' states in, the transform between their worlds
/// out.
#include "vir/core/log.h"
#include "vir/core/options.h"
#include "vir/team/pair_solver.h"

namespace vir::roles {

/// A solver with settings of its own.
class Rendezvous : public team::PairSolver {
 public:
  /// Declares the settings; called before start().
  virtual void describe(OptionVisitor& v) = 0;
  /// Before the first range.
  virtual void start(const LogSink& log) = 0;
};

}  // namespace vir::roles
