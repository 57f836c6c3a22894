#pragma once
/// A solver that notes what it is given and answers what the test wants.
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "vir/team/peer_tracker.h"

namespace vir::test {

struct Given {
  team::MutualRange range;
  int segment_A = 0, segment_B = 0;
};

struct SolverNotes {
  std::vector<Given> given;
  std::vector<team::SharedAnchor> anchors;  ///< as last set
  std::optional<SharedPlaces> places;       ///< as last set
  std::vector<team::WorldTransform> moved;
  int asked = 0;
  team::TransformStatus status = team::TransformStatus::degenerate;
  team::WorldTransform T;  ///< of the answer, if there is one
  LogSink log;
};

class FakeSolver final : public team::PairSolver {
 public:
  explicit FakeSolver(SolverNotes* notes) : notes_(notes) {}
  void add(const team::MutualRange& range, int segment_A, int segment_B) override {
    notes_->given.push_back({range, segment_A, segment_B});
  }
  void setAnchors(const std::vector<team::SharedAnchor>& anchors) override {
    notes_->anchors = anchors;
  }
  void setPlaces(const std::optional<SharedPlaces>& places) override { notes_->places = places; }
  void moveA(const team::WorldTransform& T_new_A) override { notes_->moved.push_back(T_new_A); }
  team::TransformAnswer answer() override {
    ++notes_->asked;
    team::TransformAnswer out;
    out.status = notes_->status;
    if (out.status != team::TransformStatus::unique) {
      out.reason = "the test says so";
      return out;
    }
    team::TransformSolution s;
    s.T_A_B = notes_->T;
    s.covariance *= 0.01;
    out.solutions.push_back(s);
    return out;
  }

 private:
  SolverNotes* notes_;
};

/// Makes one after the other; `notes` keeps what each was told.
inline team::PairSolverFactory fakeSolvers(std::deque<SolverNotes>* notes,
                                           team::TransformStatus status) {
  return [notes, status](const LogSink& log) {
    notes->emplace_back();
    notes->back().status = status;
    notes->back().log = log;
    return std::make_unique<FakeSolver>(&notes->back());
  };
}

}  // namespace vir::test
