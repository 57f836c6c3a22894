#pragma once
/// A recording's run in a window or a film, at the recording's pace or another.
#include <functional>
#include <memory>

#include "live/live_view.h"
#include "live/pace.h"
#include "vir/results/run_observer.h"

namespace vir::app {

class RunPlayer final : public results::RunObserver {
 public:
  struct Options {
    double speed = 1;    ///< times as fast as the recording; 0: as fast as it goes
    double start_s = 0;  ///< until then as fast as it goes [s from the first image]
    double end_s = 0;    ///< nothing is shown from then on; 0: all
  };
  /// `view` outlives this.
  RunPlayer(LiveView* view, const Options& options) : view_(*view), options_(options) {}

  void onObservation(const mrpt::obs::CObservation& observation) override;
  void onOutput(const roles::EstimatorOutput& output, const roles::Estimator& estimator) override;
  /// Its window is closed, `q` was typed, or the end is reached.
  bool over() const { return over_; }
  /// What the keys do: a line for the terminal.
  static const char* keys();

 private:
  bool shown(TimeNs t) const;
  void holdBack(TimeNs t);
  void obey(char key, TimeNs t);

  LiveView& view_;
  Options options_;
  bool over_ = false, paused_ = false, step_ = false;
  TimeNs first_ = 0, hurry_until_ = 0;
  Pace pace_;
};

/// A window of its own, at the recording's pace. Throws std::runtime_error if there is no display.
struct RunWindow {
  std::unique_ptr<LiveView> view = openLiveView();
  RunPlayer player{view.get(), RunPlayer::Options()};
};

}  // namespace vir::app
