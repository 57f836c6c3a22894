#pragma once
/// Rendezvous plugin `nlopt`: closed forms, NLopt's DIRECT where they give nothing to start from,
/// and a refinement of the full robust cost (libs/team).
#include <optional>

#include "vir/roles/rendezvous.h"
#include "vir/team/transform_tracker.h"

namespace vir {

class NloptRendezvous final : public roles::Rendezvous {
 public:
  void describe(OptionVisitor& v) override { team::describe(v, options_); }
  void start(const LogSink& log) override;
  void add(const team::MutualRange& range, int segment_A, int segment_B) override;
  void setAnchors(const std::vector<team::SharedAnchor>& anchors) override;
  void setPlaces(const std::optional<SharedPlaces>& places) override;
  void moveA(const team::WorldTransform& T_new_A) override;
  team::TransformAnswer answer() override;

 private:
  team::TransformTrackerOptions options_;
  team::TransformTracker tracker_;
  LogSink log_;
};

}  // namespace vir
