#pragma once
/// The world of several robots, and what one of them records in it.
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "simulator_options.h"

namespace vir::simulator {

struct TruePose {
  Pose T_W_B;
};
struct OdometryPose {
  Pose T_O_B;
};
struct ImuReading {
  ImuSample sample;
};
struct AnchorRange {
  simulation::SimulatedRange range;
};
struct ImageDue {
  std::uint64_t number = 0;
  int camera = 0;
};
struct TracksDue {};

/// One thing that happens, at a time on the recording's clock.
struct Event {
  TimeNs t = 0;
  std::variant<TruePose, OdometryPose, ImuReading, AnchorRange, simulation::PeerRange, ImageDue,
               TracksDue>
      what;
};

/// All motions, the place, and what the recorded robot measures; images and tracks are made when
/// they are asked for.
class World {
 public:
  /// Throws InputError naming section and key, or the file, for what cannot be simulated.
  explicit World(const SimulatorOptions& options);
  ~World();

  /// In time order; at one time truth, odometry, IMU, ranges, image.
  const std::vector<Event>& events() const;
  /// The image of an event, with noise of its own. Holds until the next call.
  const rendering::GrayImage& image(const Event& event);
  /// The tracks of an event; events must come in order.
  vision::TrackedFrame tracks(const Event& event);

  int cameras() const;
  /// As the recording says.
  const CameraCalibration& calibration(int camera = 0) const;
  const Pose& T_B_C(int camera = 0) const;
  Vec3 antenna() const;
  const rendering::Scene& scene() const;
  const simulation::Motion& motion() const;  ///< of the recorded robot
  /// What a user should know, one line each.
  std::vector<std::string> notes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::simulator
