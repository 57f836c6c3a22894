#pragma once
/// Internal: does the camera's clock agree with the IMU's? Follows the turns of images and gyro
/// until that is known.
#include <deque>
#include <string>
#include <vector>

#include "vir/initialization/image_turn.h"
#include "vir/vision/feature_tracker.h"

namespace vir::estimator {

class CameraTiming {
 public:
  enum class State {
    open,     ///< too little turning so far
    agrees,   ///< within what the window can find itself
    differs,  ///< by found().offset_s
  };

  explicit CameraTiming(double focal_px) : focal_px_(focal_px) {}

  /// Images in time order, on the IMU's clock as believed now; unusable ones break the chain.
  void add(const vision::TrackedFrame& frame);
  /// Compares with the readings. Settled once it agrees for good.
  /// `running`: a window is, and what it finds itself is left to it.
  State look(const imu::ImuBuffer& imu, const Quat& q_B_C, bool running);
  bool offsetKnown() const { return offset_known_; }
  /// Turns are followed until this is known as well: nodding tells the offset, and nothing of a
  /// rotation about the axis of the nod.
  bool rotationKnown() const { return rotation_known_; }
  void setRotationKnown() { rotation_known_ = true; }
  const initialization::TurnCorrelation& found() const { return found_; }
  /// The camera's rotation in the body by turning alone, from nothing known of it.
  initialization::CameraRotation rotation(const imu::ImuBuffer& imu) const {
    return initialization::findCameraRotation({turns_.begin(), turns_.end()}, imu);
  }
  /// Share of the turning that agrees with the readings if the camera stands like this.
  double explainedBy(const Quat& q_B_C, const imu::ImuBuffer& imu) const {
    return initialization::correlateTurns({turns_.begin(), turns_.end()}, imu, q_B_C).explained;
  }
  /// found().offset_s is worth a try, although not proved.
  bool suggests() const;
  /// The believed offset has changed.
  void shift(TimeNs by);
  /// Readings are needed from here on; 0: none.
  TimeNs oldestTime() const { return turns_.empty() ? 0 : turns_.front().t0; }
  /// Tracks were lost, or time has jumped.
  void reset();

 private:
  double focal_px_;
  struct Seen {
    TimeNs t = 0;
    std::vector<initialization::AlignmentSight> sights;
  };
  std::deque<Seen> seen_;  // what the next images are compared with
  std::deque<initialization::ImageTurn> turns_;
  initialization::TurnCorrelation found_;
  bool offset_known_ = false, rotation_known_ = false;
  int since_look_ = 0;
};

}  // namespace vir::estimator
