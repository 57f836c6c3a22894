#pragma once
/// Two cameras that may look at the same things: whether they stand to each other as the
/// calibration says.
#include <array>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "vir/camera/camera_model.h"
#include "vir/check/finding.h"
#include "vir/core/time.h"

namespace vir::check {

/// A camera as the calibration has it, and its label in the recording.
struct RigCamera {
  std::string label;
  CameraCalibration calibration;
  Pose T_B_C;
};

class RigCheck {
 public:
  /// Throws std::invalid_argument for a calibration that cannot be one.
  RigCheck(RigCamera first, RigCamera second);
  /// Whether an image of camera 0 or 1 at `t` is of use. `t`: on the clock that both share.
  bool wants(TimeNs t) const;
  /// One channel of 8 bits; in order of time per camera. Copied.
  void add(int camera, TimeNs t, const cv::Mat& gray);
  /// Nothing where too few pairs were seen.
  std::vector<Finding> findings() const;

 private:
  using Rays = std::array<Vec3, 2>;
  /// The same thing seen by both [px].
  struct Match {
    std::array<Vec2, 2> px;
  };
  struct Waiting {
    TimeNs t = 0;
    cv::Mat gray;
  };
  struct Fit;
  void pairUp();
  bool overlaps() const;
  std::vector<Rays> raysOf(const std::array<const camera::CameraModel*, 2>& models) const;
  Fit fitOf(const std::vector<Rays>& rays, const Pose& T_0_1) const;
  std::optional<Finding> faultOf(const std::vector<Rays>& plain, const Fit& given) const;
  double focalPx() const { return 0.5 * (cameras_[0].calibration.fx + cameras_[0].calibration.fy); }
  std::vector<Finding> lightFindings() const;
  Finding apart() const;
  Finding unexplained(const Fit& given) const;

  std::array<RigCamera, 2> cameras_;
  std::array<std::shared_ptr<const camera::CameraModel>, 2> models_;
  std::array<Waiting, 2> waiting_;
  std::vector<Match> matches_;
  std::vector<double> brighter_;  ///< second against first, per pair
  int pairs_ = 0;
  TimeNs next_ = 0;
};

}  // namespace vir::check
