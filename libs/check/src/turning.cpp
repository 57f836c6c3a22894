#include "vir/check/turning.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace vir::check {
namespace {

constexpr int kCorners = 200, kFewest = 25;
constexpr double kTolerancePx = 0.7;

Vec3 rotationVector(const cv::Mat& R) {
  Mat3 m;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) m(r, c) = R.at<double>(r, c);
  }
  if (m.determinant() < 0) m = -m;
  return logSO3(m);
}

}  // namespace

ImageTurning::ImageTurning(std::shared_ptr<const camera::CameraModel> camera)
    : camera_(std::move(camera)) {}

std::optional<ImageTurn> ImageTurning::between(const std::vector<cv::Point2f>& now,
                                               const std::vector<unsigned char>& found,
                                               TimeNs t) const {
  std::vector<cv::Point2d> a, b;
  for (std::size_t i = 0; i < now.size(); ++i) {
    Vec3 before, after;
    if (found[i] == 0 || !camera_->unproject(Vec2(last_points_[i].x, last_points_[i].y), &before) ||
        !camera_->unproject(Vec2(now[i].x, now[i].y), &after) || before.z() < 0.2 ||
        after.z() < 0.2) {
      continue;
    }
    a.emplace_back(before.x() / before.z(), before.y() / before.z());
    b.emplace_back(after.x() / after.z(), after.y() / after.z());
  }
  if (static_cast<int>(a.size()) < kFewest) return std::nullopt;
  cv::theRNG().state = 7;
  cv::Mat inliers;
  const double focal = camera_->calibration().fx;
  cv::Mat E =
      cv::findEssentialMat(a, b, 1.0, {0, 0}, cv::RANSAC, 0.999, kTolerancePx / focal, inliers);
  if (E.rows != 3) return std::nullopt;
  cv::Mat R1, R2, direction;
  cv::decomposeEssentialMat(E, R1, R2, direction);
  // The two differ by half a turn, and images that share their corners do not turn that far.
  const Vec3 first = rotationVector(R1), second = rotationVector(R2);
  ImageTurn turn;
  turn.t0 = last_t_;
  turn.t1 = t;
  turn.rotation_C = -(first.norm() < second.norm() ? first : second);  // they are R_C1_C0
  turn.points = cv::countNonZero(inliers);
  if (turn.points < kFewest || !turn.rotation_C.allFinite()) return std::nullopt;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (inliers.at<unsigned char>(static_cast<int>(i)) == 0) continue;
    turn.matches.emplace_back(Eigen::Vector4d(a[i].x, a[i].y, b[i].x, b[i].y).cast<float>());
  }
  return turn;
}

std::optional<ImageTurn> ImageTurning::add(TimeNs t, const cv::Mat& gray) {
  std::optional<ImageTurn> turn;
  const CameraCalibration& c = camera_->calibration();
  if (gray.type() != CV_8UC1 || gray.cols != c.width || gray.rows != c.height) return turn;
  if (!last_.empty() && !last_points_.empty()) {
    std::vector<cv::Point2f> now;
    std::vector<unsigned char> found;
    std::vector<float> error;
    cv::calcOpticalFlowPyrLK(last_, gray, last_points_, now, found, error, {21, 21}, 4);
    turn = between(now, found, t);
  }
  last_ = gray.clone();
  last_t_ = t;
  cv::goodFeaturesToTrack(last_, last_points_, kCorners, 0.01, c.width / 40.0);
  corners_ = static_cast<int>(last_points_.size());
  return turn;
}

}  // namespace vir::check
