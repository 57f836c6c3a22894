#pragma once
/// The cameras that a robot carries in the simulated world, with their errors and faults.
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "simulator_options.h"
#include "vir/core/time.h"
#include "vir/simulation/motion.h"

namespace vir::simulator {

/// Camera 0 is [Camera], camera 1 [Camera1], ...
class Rig {
 public:
  /// Throws std::invalid_argument for a list of times that does not come in pairs.
  explicit Rig(const SimulatorOptions& options);

  int size() const { return static_cast<int>(cameras_.size()); }
  const CameraOptions& options(int camera) const { return at(camera).options; }
  /// As the recording says.
  const CameraCalibration& calibration(int camera) const { return at(camera).calibration; }
  const Pose& T_B_C(int camera) const { return at(camera).T_B_C; }
  /// As it is.
  std::shared_ptr<const camera::CameraModel> model(int camera) const { return at(camera).model; }
  const Pose& trueT_B_C(int camera) const { return at(camera).true_T_B_C; }

  /// From now on there is something to be seen.
  void look(std::shared_ptr<const rendering::Scene> scene,
            std::shared_ptr<const simulation::Motion> motion);
  /// Stamps of a camera's images, with the number that chooses their noise.
  std::vector<std::pair<TimeNs, std::uint64_t>> stamps(int camera) const;
  /// The image of a stamp; holds until the next call.
  const rendering::GrayImage& image(int camera, TimeNs stamp, std::uint64_t number);

 private:
  struct Camera {
    CameraOptions options;
    CameraCalibration calibration;
    Pose T_B_C, true_T_B_C;
    std::shared_ptr<const camera::CameraModel> model;
    std::unique_ptr<rendering::CameraSimulator> simulator;
    rendering::GrayImage shown;  ///< the last one, while it is frozen or black
  };
  const Camera& at(int camera) const { return cameras_[static_cast<std::size_t>(camera)]; }

  std::vector<Camera> cameras_;
  rendering::CameraSimulationOptions effects_;
  int surface_seed_;
  std::shared_ptr<const simulation::Motion> motion_;
};

}  // namespace vir::simulator
