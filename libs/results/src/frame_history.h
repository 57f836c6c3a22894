#pragma once
/// What the page of a run shows over time, thinned out as the run grows.
#include <string>
#include <utility>
#include <vector>

#include "vir/types/state.h"

namespace vir::results {

struct FrameSample {
  TimeNs t = 0;
  bool valid = false;
  State state;
  Vec3 sigma_p = Vec3::Zero();  ///< per axis of W [m]; 0 = not known
  Vec3 sigma_r = Vec3::Zero();  ///< per axis of the body [rad]
  int tracks = 0, landmarks = 0;
  double reprojection_rms = 0, inertial_rms = 0;
  double ms = 0;  ///< the most of the images that this one stands for
};

/// A change of health, or a new start.
struct FrameEvent {
  TimeNs t = 0;
  std::string text;
  bool bad = false;
};

class FrameHistory {
 public:
  void add(const StateEstimate& estimate);
  /// What was added so far is of another frame.
  void changeFrame(const Pose& T_new_old);
  /// Evenly thinned out: at most twice kShown.
  const std::vector<FrameSample>& samples() const { return samples_; }
  /// The first kMostEvents of them.
  const std::vector<FrameEvent>& events() const { return events_; }

  static constexpr std::size_t kShown = 1800, kMostEvents = 300;

 private:
  void noteEvent(const StateEstimate& estimate);

  std::vector<FrameSample> samples_;
  std::vector<FrameEvent> events_;
  std::string health_;
  double ms_ = 0;  // the most since the last sample
  int segment_ = 0;
  long stride_ = 1, seen_ = 0;
};

}  // namespace vir::results
