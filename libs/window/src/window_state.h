#pragma once
/// Internal: frames, landmarks and prior of the short window, shared by its translation units.
#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "minimiser.h"
#include "vir/camera/radial_response.h"
#include "vir/factors/head_range_factor.h"
#include "vir/factors/imu_factor.h"
#include "vir/factors/linear_prior_factor.h"
#include "vir/factors/motion_factors.h"
#include "vir/factors/node_range_difference_factor.h"
#include "vir/factors/node_range_factor.h"
#include "vir/factors/pose_manifold.h"
#include "vir/factors/reprojection_factor.h"
#include "vir/factors/window_range_factor.h"
#include "vir/window/long_window.h"
#include "vir/window/marginalization.h"
#include "vir/window/short_window.h"

namespace vir::window {

struct Frame {
  TimeNs t = 0;
  double pose[7];
  double speed_bias[9];
  bool fixed = false;  ///< its first estimate is in the prior: Jacobians are taken there
  double lin_pose[7];
  double lin_speed_bias[9];
  bool keyframe = false;
  bool standing = false;
  std::unique_ptr<imu::Preintegration> link;  ///< from the frame before it
  /// Of the state as it was when the problem was set up; see noteRotations().
  Mat3 R_B_W = Mat3::Identity();
  Vec3 rate = Vec3::Zero();       ///< of its turning as measured then [rad/s], body
  std::vector<HeldRange> ranges;  ///< vectors in its body frame
  std::size_t index = 0;          ///< in the window, as of the last rejectOutlierSights()

  Pose T_W_B() const { return factors::poseFrom(pose); }
  /// Where Jacobians must be taken; nullptr = at the current value.
  const double* linPose() const { return fixed ? lin_pose : nullptr; }
  const double* linSpeedBias() const { return fixed ? lin_speed_bias : nullptr; }
  void fixFirstEstimate() {
    if (fixed) return;
    std::copy(pose, pose + 7, lin_pose);
    std::copy(speed_bias, speed_bias + 9, lin_speed_bias);
    fixed = true;
  }
};

struct LandmarkSight {
  Frame* frame = nullptr;
  int camera = 0;  ///< of the rig
  factors::Sight sight;
  double row = 0;                  ///< see factors::bearingByCamera
  Vec2 off_centre = Vec2::Zero();  ///< its pixel against the given principal point [px]

  bool hasRate() const { return !sight.by_camera.col(factors::kTimeOffset).isZero(); }
  void setRate(const Vec3& rate) {
    sight.by_camera.col(factors::kTimeOffset) = -rate;
    sight.by_camera.col(factors::kReadout) = -row * rate;
  }
  /// Where it would be without noise, against the principal point [px].
  /// `radial`: see factors::bearingByCamera, there.
  void setPlace(const Vec2& off, const Vec2& radial) {
    // The columns of the principal point are the bearing's change with the pixel.
    const auto by_cx = sight.by_camera.col(factors::kCx), by_cy = sight.by_camera.col(factors::kCy);
    sight.by_camera.col(factors::kFocal) = by_cx * off.x() + by_cy * off.y();
    sight.by_camera.col(factors::kAspect) = by_cx * off.x() - by_cy * off.y();
    const auto by_focal = sight.by_camera.col(factors::kFocal);
    sight.by_camera.col(factors::kRadial1) = radial.x() * by_focal;
    sight.by_camera.col(factors::kRadial2) = radial.y() * by_focal;
  }
};

struct WindowLandmark {
  std::vector<LandmarkSight> sights;  ///< oldest first; the first is the host's
  factors::HostRay ray;
  double x[3] = {0, 0, 0};  ///< u, v, inverse distance
  bool has_depth = false;
  bool unchecked = true;  ///< no rejectOutlierSights() since it has a depth

  Frame* host() const { return sights.front().frame; }
  int hostCamera() const { return sights.front().camera; }
  /// Point in the host's camera.
  Vec3 inCamera(const factors::CameraVector& camera) const {
    return (ray.bearingAt(camera) + ray.basis * Vec2(x[0], x[1])) / x[2];
  }
  void setHostRay() {
    static_cast<factors::CameraRay&>(ray) = sights.front().sight;
    ray.basis = factors::tangentBasis(ray.bearing);
  }
};

/// What the information of all terms of camera and IMU says at a keyframe. "Relative": against the
/// position and yaw of the oldest frame, in O's axes.
struct WindowCovariance {
  /// Newest frame relative to the oldest: position, rotation on the right.
  Eigen::Matrix<double, 6, 6> newest = Eigen::Matrix<double, 6, 6>::Zero();
  std::optional<CalibrationCovariance> calibration;
  std::vector<CalibrationSigma> further;  ///< of camera 1, 2, ...; those of the IMU are 0
  std::vector<double> distance_sigma_m;   ///< of these from the first, by what the terms promise
  /// Where the terms would have the calibration if nothing of it were held: from where it is.
  CalibrationChange calibration_step = CalibrationChange::Zero();
  Eigen::Matrix4d edge = Eigen::Matrix4d::Identity();   ///< second frame relative to the oldest
  Eigen::Matrix4d claim = Eigen::Matrix4d::Identity();  ///< oldest frame in O: position, yaw
};

/// How the sights fit against what sigma_px promises: mean square of whitened residuals over the
/// last solutions. The same camera may be three times better or worse than a fixed sigma.
struct SightLevel {
  double mean_square = 1;
  int solutions = 0;
  void add(double rms, int sights);
};

/// Factors that are used again in the next problem.
template <typename Factor>
class Recycled {
 public:
  Factor& next() {
    if (used_ == factors_.size()) factors_.emplace_back();
    return factors_[used_++];
  }
  void startOver() { used_ = 0; }

 private:
  std::deque<Factor> factors_;
  std::size_t used_ = 0;
};

/// Of the sights. A problem has thousands, and each has memory of its own.
struct SightFactors {
  Recycled<factors::ReprojectionFactor> reprojections;
  Recycled<factors::ReprojectionCalibrationFactor> calibrations;
  Recycled<factors::RigReprojectionFactor> rig_sights;
  Recycled<factors::HostSightFactor> host_sights;
  Recycled<factors::PointSightFactor> point_sights;
  void startOver() {
    reprojections.startOver();
    calibrations.startOver();
    rig_sights.startOver();
    host_sights.startOver();
    point_sights.startOver();
  }
};

/// A camera beside the first.
struct FurtherCamera {
  CameraCalibration given;
  camera::RadialResponse radial_response;
  CalibrationSigma sigma;
  double offset_to_first_s = 0;  ///< of the clocks, as the images were put together
  double extrinsic[7];
  double parameters[factors::kCameraParameters] = {};
};

struct WindowState {
  WindowOptions options;
  imu::ImuNoise noise;
  CameraCalibration camera;                ///< as given: sights are bearings by it
  camera::RadialResponse radial_response;  ///< nothing where the lens is taken as given
  CalibrationSigma calibration_sigma;
  bool shutter_decided = false;  ///< see decideShutter()
  bool lens_held = false;        ///< see watchLens()
  int lens_doubts = 0;           ///< keyframes in a row that contradict the lens
  double stamp_offset_s = 0;     ///< time offset that new frames are stamped with
  double stamp_sigma_s = 0;      ///< of the stamp of each new frame
  double extrinsic[7];
  double camera_parameters[factors::kCameraParameters] = {};
  std::deque<FurtherCamera> further;  ///< camera 1, 2, ...
  double imu_intrinsics[imu::kImuIntrinsicsSize] = {};
  std::deque<std::unique_ptr<Frame>> frames;
  std::map<std::uint64_t, WindowLandmark> landmarks;  ///< ordered by id: same sums in every run
  factors::LinearPrior prior;
  std::vector<double*> prior_blocks;
  std::vector<Landmark> retired_landmarks;
  factors::PoseManifold pose_manifold;
  LongWindow* long_window = nullptr;  ///< not owned; nullptr: no ranges, no covariance in W
  WindowCovariance covariance;
  SightLevel sight_level;
  Minimiser minimiser, tail_minimiser;
  SightFactors sight_factors;  ///< of the last TermSet with sights
  /// `minimiser` has the information of the frames as they are now.
  bool information_known = false;
  /// Frames from this index on have moved since the last rejectOutlierSights().
  std::size_t moved_from = 0;

  bool ranging() const { return long_window && !long_window->anchors().empty(); }

  Pose T_B_C(int number = 0) const {
    return factors::poseFrom(number == 0 ? extrinsic : beside(number).extrinsic);
  }
  factors::CameraVector cameraVector(int number = 0) const {
    return factors::CameraVector(number == 0 ? camera_parameters : beside(number).parameters);
  }
  const FurtherCamera& beside(int number) const {
    return further[static_cast<std::size_t>(number) - 1];
  }
  double* extrinsicOf(int number) {
    return number == 0 ? extrinsic : further[static_cast<std::size_t>(number) - 1].extrinsic;
  }
  double* parametersOf(int number) {
    return number == 0 ? camera_parameters
                       : further[static_cast<std::size_t>(number) - 1].parameters;
  }
  const CameraCalibration& cameraOf(int number) const {
    return number == 0 ? camera : beside(number).given;
  }
  const camera::RadialResponse& responseOf(int number) const {
    return number == 0 ? radial_response : beside(number).radial_response;
  }
  int cameras() const { return 1 + static_cast<int>(further.size()); }
  imu::ImuIntrinsics imuIntrinsics() const { return imu::ImuIntrinsics(imu_intrinsics); }
  double focalPx() const { return 0.5 * (camera.fx + camera.fy); }
  bool calibrating() const { return options.calibrate; }
  Frame& newest() { return *frames.back(); }
  LandmarkSight sightOf(const vision::FeatureObservation& o) const;
  void believeLessAlong(const Vec2& px_rate, Mat23* weight) const;
};

/// The residuals of (part of) the window, with the cost functions they point to. Only one at a time
/// can have sights.
class TermSet {
 public:
  explicit TermSet(WindowState& w) : w_(w) {}
  /// Everything in the window that camera and IMU say.
  void addAll();
  /// What the long window says of its head and the anchors, and the ranges of all frames.
  void addRanges();
  void addDifference(const Frame& frame, const HeldRange& r, AnchorNode& a);
  /// What the frames from index `first` on feel of the rest, with landmarks and older frames taken
  /// as known.
  void addTail(std::size_t first);
  /// What involves the oldest frame: prior, its link, rest, and the landmarks in `ids`.
  void addOldest(const std::vector<std::uint64_t>& ids);
  const std::vector<Term>& terms() const { return terms_; }
  int sights() const { return sights_; }

 private:
  void addPrior();
  void addLink(Frame& a, Frame& b);
  /// The same with the IMU's intrinsics taken as known.
  void addFixedLink(Frame& a, Frame& b);
  /// `further` are the factor's blocks after the two frames' poses, speeds and biases.
  template <typename Factor>
  void addLinkTerm(Factor& f, Frame& a, Frame& b, std::initializer_list<double*> further);
  void addRest(Frame& a, Frame* before);
  void addLandmark(WindowLandmark& l);
  /// A sight of another camera than the host's.
  void addRigSight(WindowLandmark& l, LandmarkSight& s);
  template <typename Factor, typename... Args>
  Factor& make(Args&&... args);

  WindowState& w_;
  std::vector<Term> terms_;
  std::deque<factors::WindowRangeFactor> window_ranges_;
  std::deque<factors::HeadRangeFactor> head_ranges_;
  std::deque<factors::NodeRangeFactor> rigid_ranges_;
  std::deque<factors::NodeRangeDifferenceFactor> rigid_differences_;
  factors::LinearPrior message_;
  std::vector<std::unique_ptr<ceres::CostFunction>> others_;
  int sights_ = 0;
};

/// See ShortWindow::resect().
Resected resect(const WindowState& w, const Pose& predicted,
                const std::vector<vision::FeatureObservation>& features, double far_px);

/// How the bearings of a landmark's sights change with the camera's parameters, out of the motion
/// and the landmark as estimated. The pixels themselves, and their difference to the image before,
/// have the sight's own noise in them: as a Jacobian that would pull the parameters to one side
/// (errors in variables; 0.5 ms and 0.4 % of the focal length at 0.3 px).
void updateCameraJacobians(const WindowState& w, WindowLandmark* l);
/// Once before updateCameraJacobians() is called for many landmarks.
void noteRotations(WindowState& w);

/// Blocks of frames (and calibration) in window order.
std::vector<BlockRef> frameBlocks(WindowState& w, std::size_t first, std::size_t count);

/// Residual of a sight of a landmark at `x` (u, v, inverse distance), whitened.
Vec2 sightResidual(const WindowState& w, const WindowLandmark& l, const LandmarkSight& s,
                   const factors::SightGeometry& between, const Vec3& x);

/// What is known of a further camera against the first: rigs are calibrated as one, far better than
/// a camera is against an IMU, as far as the matches between them agree; see setRigMisfit().
CalibrationSigma rigSigma(const WindowState& w, const FurtherCamera& camera, double misfit_px);
/// What is known of the calibration at the beginning, to a prior that has the first frame's blocks.
void addCalibrationPrior(WindowState& w);
void takeCalibration(WindowState& w, const Calibration& calibration);
Calibration calibrationOf(const WindowState& w);

/// Of the cameras, behind all frames, if they are estimated.
void addCalibrationBlocks(WindowState& w, std::vector<BlockRef>* order);

/// Blocks in the order that is cheap to solve: `leading` speeds and biases, from the newest on,
/// then poses and calibration.
std::vector<BlockRef> leadingOrder(WindowState& w, std::size_t* leading);

/// Information of all terms of camera and IMU, over the poses of all frames and the calibration.
NormalEquations informationOf(WindowState& w);
/// Fills in `w.covariance` and the joint covariance of head and anchors.
void updateCovariance(WindowState& w);
/// Most cameras have a global shutter, and the others one that takes milliseconds: once the sights
/// tell which, what is next to nothing is held at nothing. Call after updateCovariance().
void decideShutter(WindowState& w);
/// The lens of most calibrations is right, and estimating it all the same costs accuracy: it is
/// held as given until what the sights say of it contradicts that beyond doubt. All terms and the
/// prior keep its columns, so that nothing is lost until then. Call after updateCovariance().
void watchLens(WindowState& w);
/// As if a held lens were known exactly.
void holdLens(const WindowState& w, NormalEquations* information);
/// The oldest frame, about to be marginalised, becomes a node of the long window.
void handToLongWindow(WindowState& w);
/// What NodeRangeFactor needs for a range of a frame with the short window taken as rigid: as if
/// its oldest frame held it.
struct RigidRange {
  factors::RangeTerm term;
  Vec3 motion_O = Vec3::Zero(), lever_O = Vec3::Zero();
};
RigidRange rigidRange(const WindowState& w, const Frame& f, const HeldRange& r);
/// Moves the ranges of a frame that is dropped to another.
void moveRanges(Frame* from, Frame* to);

State navStateOf(const Frame& f);
Vec3 landmarkInWorld(const WindowState& w, const WindowLandmark& l);

int triangulateLandmarks(WindowState& w);
/// Of all sights if everything moved, else of those of the frames that did.
std::vector<std::uint64_t> rejectOutlierSights(WindowState& w);
/// Removes the sights of a frame; landmarks hosted there move to their next sight.
void removeSightsOf(WindowState& w, const Frame* frame);
bool decideKeyframe(const WindowState& w);
/// Newest and the frame before it stand still, and the link between them is at its longest.
bool endsRestLink(const WindowState& w);
void dropNewestInto(WindowState& w, imu::Preintegration* link);
void marginalizeOldest(WindowState& w);
SolveSummary solveWindow(WindowState& w, int iterations);
/// Only the frames from index `first` on move; landmarks and older frames are taken as known.
SolveSummary solveTail(WindowState& w, int iterations, std::size_t first);

}  // namespace vir::window
