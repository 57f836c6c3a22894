#pragma once
/// The short window Psi (paper, section "Double Layer Tightly Coupled VIR Optimization"): the
/// newest keyframes and the newest image, their landmarks, the inertial links between them, and the
/// prior that marginalisation left.
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "vir/geometry/pose.h"
#include "vir/imu/preintegration.h"
#include "vir/types/calibration_change.h"
#include "vir/types/state.h"
#include "vir/vision/feature_tracker.h"
#include "vir/window/long_window.h"

namespace vir::window {

/// How a reprojection beyond loss_scale sigma counts.
enum class ReprojectionLoss { huber, cauchy };

/// How far sights are from where a pose puts their landmarks (those with a depth).
struct SightFit {
  int sights = 0;
  double median_px = 0;
};

/// What the sights of an image say about its pose.
struct Resected {
  Pose T_W_B;          ///< as predicted where the sights fit that, or are too few
  SightFit predicted;  ///< at the prediction
  SightFit found;      ///< at T_W_B
  /// By how much the sights that move are ahead of the prediction along their way [s]: the image
  /// was taken so much later than predicted for. Empty where too few move.
  std::optional<double> late_s;
};

/// What becomes of the lens' radial coefficients.
enum class LensMode {
  watched,  ///< as given, until the sights are sure that it is another
  free,     ///< estimated from the first image on
  given     ///< as given
};

struct WindowOptions {
  int keyframes = 14;
  int iterations = 2;
  int iterations_newest = 3;
  int newest_frames = 1;
  bool full_every_image = false;
  double sigma_px = 0.3;
  ReprojectionLoss loss = ReprojectionLoss::cauchy;
  double loss_scale = 1.0;
  double outlier_sigma = 4.0;
  double keyframe_parallax_px = 12.0;
  double keyframe_min_shared = 0.5;
  double keyframe_max_interval_s = 0.6;
  double min_parallax_px = 3.0;
  bool first_estimate_jacobians = true;
  bool calibrate = true;
  CalibrationSigma calibration;
  LensMode lens = LensMode::watched;
  double time_offset_walk = 1e-4;  ///< [s/sqrt(s)]
  double readout_s = 0;
  double rest_sigma_v_mps = 0.01;
  double rest_sigma_p_m = 0.001;
  double rest_sigma_theta_rad = 0.0005;

  /// Throws std::invalid_argument for a value that is not allowed, and for values that contradict
  /// each other.
  void validate() const;
};
/// Section [Window].
void describe(OptionVisitor& v, WindowOptions& o);
/// `calibrate` in the section at hand.
void describeCalibrate(OptionVisitor& v, WindowOptions& o);

/// The state that the readings of `link` lead to from `from`; gravity [m/s^2] along -z of W.
State predict(const State& from, const imu::Preintegration& link, double gravity, TimeNs t);

/// Standard deviations of what is assumed known about the first frame.
struct StartPrior {
  double position_m = 1e-3;
  double yaw_rad = 1e-3;
  double tilt_rad = 0;      ///< 0 = unknown
  double velocity_mps = 0;  ///< 0 = unknown
  double bias_gyro = 0.1;
  double bias_acc = 0.2;
};

struct SolveSummary {
  int iterations = 0;
  double initial_cost = 0, final_cost = 0;
  bool usable = false;          ///< finite and not worse than before
  int sights = 0;               ///< reprojections in the problem
  double reprojection_rms = 0;  ///< whitened, per coordinate, after the solution
  /// Of the readings between the frames that moved, likewise (position, rotation, velocity).
  double inertial_rms = 0;
};

/// How far a landmark is from the newest frame's camera, along its ray there.
struct LandmarkDistance {
  std::uint64_t id = 0;
  double inverse_distance = 0;  ///< [1/m]
  double sigma = 0;             ///< of it, by the way between the sights [1/m]
};

/// Accuracy of the motion inside the window, from the information of all its terms.
struct WindowAccuracy {
  double baseline_m = 0;        ///< largest distance between two frames
  double baseline_sigma_m = 0;  ///< standard deviation of that distance
  double tilt_sigma_rad = 0;    ///< of the newest frame's roll and pitch
};

/// How far a further camera is from the first [m].
struct RigDistance {
  double assumed_sigma_m = 0;  ///< of what was given, see setRigMisfit()
  double sigma_m = 0;          ///< by now, were all errors of sights independent
};

class ShortWindow {
 public:
  /// Frames are stamped with the calibration's time offset until stampWith() says otherwise.
  ShortWindow(const WindowOptions& options, const imu::ImuNoise& noise,
              const Calibration& calibration);
  ~ShortWindow();

  void clear();
  bool empty() const;
  int frames() const;

  /// First frame, with what is known about it.
  void start(const State& state, const StartPrior& prior,
             const std::vector<vision::FeatureObservation>& features, bool standing);
  /// Next frame; `link` leads to it from the newest. `standing`: the body has not moved since the
  /// newest frame, which was standing too.
  void push(const State& predicted, imu::Preintegration link,
            const std::vector<vision::FeatureObservation>& features, bool standing);
  /// Is an image that is about to be pushed where it is predicted to be, T_W_B? Where the median of
  /// its sights is `far_px` off or more, the pose is found that explains them best.
  Resected resect(const Pose& predicted, const std::vector<vision::FeatureObservation>& features,
                  double far_px) const;
  /// Keeps the newest frame as a keyframe whatever the policy says (while an initialisation fills
  /// the window).
  void keepNewest();

  /// Gives depth to tracks that have parallax now; returns how many.
  int triangulate();
  /// Everything in the window moves.
  SolveSummary optimise(int iterations);
  /// Only the newest frames move: cheap, for an image that will not stay as a keyframe.
  SolveSummary optimiseNewest(int iterations);
  /// Whether the newest frame is to stay as a keyframe: from its tracks and the predicted rotation.
  bool newestIsKeyframe() const;
  /// The newest frame ends a long stretch of rest, about to be cut off: time to solve everything,
  /// so that the biases learn from it.
  bool newestEndsRestLink() const;
  /// Drops sights and landmarks that contradict the solution; ids of tracks to be given up.
  std::vector<std::uint64_t> rejectOutliers();
  /// Makes room for the next frame: keeps the newest as a keyframe (and marginalises the oldest
  /// when the window is full), or marks it to be replaced.
  void slide(bool keyframe);

  State newest() const;
  State oldest() const;
  std::vector<State> states() const;
  std::vector<Landmark> landmarks() const;
  /// Landmarks that newest sees and that have a depth.
  int landmarksInNewest() const;
  /// Of those: how far they are.
  std::vector<LandmarkDistance> distancesInNewest() const;
  /// Everything goes to the long window as it is (before clear(), when the odometry is lost).
  void moveAllToLongWindow();
  /// Landmarks that left the window since the last call, as last estimated, in O.
  std::vector<Landmark> takeRetiredLandmarks();
  WindowAccuracy accuracy() const;
  /// Ties the window to the long one (not owned, must outlive this): keyframes that leave become
  /// its nodes, and its ranges and anchors are part of every full solve.
  void attach(LongWindow* long_window);
  /// Adds a range to the newest frame; vectors in that frame's body axes.
  void addRange(const HeldRange& range);
  /// All ranges of an anchor in this window, `motion` being the antenna's position in O, `lever`
  /// its lever arm there.
  std::vector<HeldRange> rangesInO(std::uint64_t anchor) const;
  /// Likewise all differences of ranges.
  std::vector<HeldRange> differencesInO() const;
  /// All ranges in this window as if held by its oldest frame, vectors in O's axes.
  std::vector<HeldRange> rangesAtOldest() const;
  /// Works out the covariances below at the present state (as costly as a marginalisation).
  void updateCovariance();
  /// Covariance of (position, rotation on the right) of the newest frame against position and yaw
  /// of the oldest, in O's axes, as of the last updateCovariance().
  Eigen::Matrix<double, 6, 6> newestCovariance() const;
  /// How far the matches between a rig's cameras lie beside their epipolar curves [px], 0 without
  /// any: the farther, the less is known of each camera against the first, down to what is known of
  /// that one in the body. Before start().
  void setRigMisfit(double px);
  Pose extrinsics() const;
  double timeOffset() const;
  /// Of the IMU, as estimated by now: what links are integrated with.
  imu::ImuIntrinsics imuIntrinsics() const;
  /// Before start(): what other means say of it. Frames are stamped with it from now on.
  void setTimeOffset(double time_offset_s, double sigma_s);
  /// Before start(): another calibration to begin with.
  void setCalibration(const Calibration& calibration);
  /// The frames given from now on are stamped with this offset, near the estimated one.
  void stampWith(double time_offset_s);
  /// Stamps of the images given from now on are off by about so much, each by itself [s]: what
  /// moves in them is believed accordingly less along its way.
  void setStampSigma(double sigma_s);
  /// As estimated by now.
  Calibration calibration() const;
  /// The sights are sure that the lens is another than given (LensMode::watched).
  bool lensContradicted() const;
  /// How far the camera's pose in the body may be off, for windows that begin from now on; no less
  /// than the options say.
  void setExtrinsicsSigma(double position_m, double rotation_rad);
  /// How sure that is, as of the last updateCovariance(); the priors before.
  CalibrationSigma calibrationSigma() const;
  /// The same of the cameras beside the first, in the body and not against the first; those of the
  /// IMU are 0. None before the first updateCovariance().
  std::vector<CalibrationSigma> furtherSigma() const;
  /// Of the distances of those from the first. None before the first updateCovariance().
  std::vector<RigDistance> rigDistances() const;
  /// The same in full (see vir::CalibrationChange); nothing before the first updateCovariance().
  std::optional<CalibrationCovariance> calibrationCovariance() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vir::window
