#pragma once
/// Rendezvous plugin `nlopt`: closed forms, NLopt's DIRECT where they give nothing to start from,
/// and a refinement of the full robust cost (libs/alignment).
#include <optional>

#include "vir/alignment/transform_tracker.h"
#include "vir/pipeline/rendezvous.h"

namespace vir {

class NloptRendezvous final : public Rendezvous {
 public:
  void describe(OptionVisitor& v) override { vir::describe(v, options_); }
  void start(const LogSink& log) override;
  void add(const MutualRange& range, int segment_A, int segment_B) override;
  void setAnchors(const std::vector<SharedAnchor>& anchors) override;
  TransformAnswer answer() override;

 private:
  TransformTrackerOptions options_;
  TransformTracker tracker_;
  LogSink log_;
};

}  // namespace vir
