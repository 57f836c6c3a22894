#pragma once
/// How the camera turned from image to image, by the images alone.
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "vir/camera/camera_model.h"
#include "vir/core/time.h"

namespace vir::check {

/// Rotation between two images of a camera.
struct ImageTurn {
  TimeNs t0 = 0, t1 = 0;
  Vec3 rotation_C = Vec3::Zero();  ///< rotation vector of R_C0_C1 [rad]
  int points = 0;                  ///< that agree
  /// These, as x, y before and x, y after, on the plane at depth 1.
  std::vector<Eigen::Vector4f> matches;
};

/// Follows corners from image to image and takes the rotation out of the essential matrix. Same
/// input, same bytes out.
class ImageTurning {
 public:
  explicit ImageTurning(std::shared_ptr<const camera::CameraModel> camera);
  /// Empty for the first image and where too little agrees. `gray`: one channel of 8 bits, of the
  /// camera's size.
  std::optional<ImageTurn> add(TimeNs t, const cv::Mat& gray);
  /// Corners found in the last image.
  int corners() const { return corners_; }

 private:
  std::optional<ImageTurn> between(const std::vector<cv::Point2f>& now,
                                   const std::vector<unsigned char>& found, TimeNs t) const;

  std::shared_ptr<const camera::CameraModel> camera_;
  cv::Mat last_;
  std::vector<cv::Point2f> last_points_;
  TimeNs last_t_ = 0;
  int corners_ = 0;
};

}  // namespace vir::check
