#pragma once
/// What is remembered of an image: corners spread over it, each with its ray, its distance if it is
/// known, and a binary descriptor.
#include <memory>
#include <vector>

#include "vir/camera/camera_model.h"
#include "vir/core/options.h"
#include "vir/geometry/pose.h"
#include "vir/types/image.h"
#include "vir/types/loop.h"

namespace vir::places {

struct DescriberOptions {
  int points = 200;             ///< per keyframe, landmarks first
  double min_distance_px = 10;  ///< of a further corner to others
  double min_corner_score = 20;

  /// Throws std::invalid_argument for a value that is not allowed.
  void validate() const;
};
void describe(OptionVisitor& v, DescriberOptions& o);

/// A landmark that the estimator sees in the image.
struct SeenLandmark {
  Vec2 px = Vec2::Zero();       ///< of the image as recorded
  double inverse_distance = 0;  ///< along the pixel's ray, from the camera [1/m]; 0: not known
  double sigma = 0;             ///< of it [1/m]
};

/// What an image shows along a ray, if it is of the place that it is taken for.
struct ExpectedPoint {
  Vec3 ray_C = Vec3::UnitZ();  ///< in the camera
  std::array<std::uint8_t, 32> descriptor{};
};

/// Not for two threads at a time. Same input, same points.
class Describer {
 public:
  /// Throws std::invalid_argument without a camera or for options that are not allowed.
  Describer(const DescriberOptions& options, std::shared_ptr<const camera::CameraModel> camera);
  ~Describer();

  /// The landmarks (of those too near to the rim or with values that are not finite none), then
  /// further corners. `R_W_C` (W with z up) turns the patches upright. Empty for an image that is
  /// none or not of the camera's size.
  std::vector<PlacePoint> points(const Image& gray, const Quat& R_W_C,
                                 const std::vector<SeenLandmark>& landmarks);

  /// By how many bits the image differs from what is expected, there or close beside, corner or
  /// not; -1 where that is not in the image.
  std::vector<int> compare(const Image& gray, const Quat& R_W_C,
                           const std::vector<ExpectedPoint>& expected);

  /// The camera as it is known by now: of the same size.
  void setCamera(std::shared_ptr<const camera::CameraModel> camera);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Rays of points that were described with another calibration of the camera. Those that this one
/// has no ray for keep theirs.
void setRays(const camera::CameraModel& camera, std::vector<PlacePoint>* points);

/// The most that the ray of a pixel, of nine all over the image, differs between the two [px].
double raysMoved(const camera::CameraModel& a, const camera::CameraModel& b);

}  // namespace vir::places
