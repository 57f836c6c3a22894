#pragma once
/// Two cameras that may look at the same things: whether they stand to each other as the
/// calibration says.
#include <array>
#include <functional>
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

/// The body in a world of true metres at a time of the images' clock; empty where not known.
using BodyPath = std::function<std::optional<Pose>(TimeNs)>;

/// How long the way between the cameras is, by how far the first one moves between two pairs.
class RigLength {
 public:
  /// Of a pair of images: what both see [px], and its descriptors in the first; then all corners
  /// of the first image. In order of time.
  struct Sights {
    TimeNs t = 0;
    std::vector<std::array<Vec2, 2>> both;
    cv::Mat descriptors;
    std::vector<Vec2> corners;
    cv::Mat corner_descriptors;
  };
  void add(Sights sights);

  struct Result {
    double times = 1;  ///< as long as given
    double sigma = 0;
    int steps = 0;  ///< that could be used; the rest means nothing with few of them
  };
  Result compare(const std::array<const camera::CameraModel*, 2>& models, const Pose& T_B_0,
                 const Pose& T_0_1, double focal_px, const BodyPath& path) const;

 private:
  /// The same thing in both images of a pair, and in the first camera's of the next.
  struct Step {
    TimeNs t0 = 0, t1 = 0;
    std::vector<std::array<Vec2, 3>> seen;
  };
  std::optional<double> ratioOf(const Step& step,
                                const std::array<const camera::CameraModel*, 2>& models,
                                const Pose& T_0_1, const Pose& moved, double focal_px) const;
  Sights last_;
  std::vector<Step> steps_;
};

class RigCheck {
 public:
  /// Throws std::invalid_argument for a calibration that cannot be one.
  RigCheck(RigCamera first, RigCamera second);
  /// Whether an image of camera 0 or 1 at `t` is of use. `t`: on the clock that both share.
  bool wants(TimeNs t) const;
  /// One channel of 8 bits; in order of time per camera. Copied.
  void add(int camera, TimeNs t, const cv::Mat& gray);
  /// Nothing where too few pairs were seen. `path` tells how far the cameras are apart; without it
  /// that cannot be judged.
  std::vector<Finding> findings(const BodyPath& path = {}) const;

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
  Finding samePlace(const std::vector<Rays>& plain, const Fit& given) const;
  Finding lengthFinding(const Fit& given, const BodyPath& path) const;
  Finding apart() const;
  Finding unexplained(const Fit& given) const;

  std::array<RigCamera, 2> cameras_;
  std::array<std::shared_ptr<const camera::CameraModel>, 2> models_;
  std::array<Waiting, 2> waiting_;
  std::vector<Match> matches_;
  RigLength length_;
  std::vector<double> brighter_;  ///< second against first, per pair
  int pairs_ = 0;
  TimeNs next_ = 0;
};

}  // namespace vir::check
