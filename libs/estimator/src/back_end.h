#pragma once
/// Internal: from tracks and readings to a state: propagate, optimise, slide (back_end.cpp), and
/// where the windows and the ranges meet (double_window.cpp).
#include <cmath>
#include <deque>
#include <map>
#include <optional>

#include "camera_timing.h"
#include "doubts.h"
#include "old_keyframes.h"
#include "packet.h"
#include "stamp_jitter.h"
#include "vir/estimator/visual_inertial_estimator.h"
#include "vir/initialization/inertial_alignment.h"

namespace vir::estimator {

struct BackEnd {
  BackEnd(const EstimatorConfig& c, LogSink l)
      : config(c),
        log_sink(std::move(l)),
        rest(c.rest),
        long_window(c.long_window),
        ranges(c.ranges, &long_window, log_sink),
        imu_noise(c.imu),
        time_offset_s(c.camera_time_offset_s) {}

  void setCamera(const CameraCalibration& calibration, const Pose& extrinsics);
  void addCamera(const CameraMount& mount) {
    given.further.push_back(mount);
    window->setCalibration(given);
  }
  /// Packets in the order they were made.
  Feedback process(Packet packet);

  void takeIn(const Packet& packet);
  StateEstimate estimate(Packet* packet);
  void estimateInto(Packet* packet, StateEstimate* out);
  /// Of an image that brings no state.
  Health withoutState() const;
  void estimateImage(Packet* packet, StateEstimate* out);
  /// Puts the image on the IMU's clock; false if the readings do not reach that far yet.
  bool putOnImuClock(Packet* packet);
  /// Looks whether the clocks agree; true if a running window had to be given up for that.
  bool checkTiming(const vision::TrackedFrame& frame);
  /// A rawlog's way to say that nobody knows the camera's pose in the body is the identity.
  void expectUnknownPose();
  /// Is the camera turned against what is given of it? It is taken as it is found, and doubted
  /// (camera_rotation.cpp); a window that runs with the other rotation begins a new segment.
  void checkCameraRotation(TimeNs t);
  /// `turn`: of the camera as found, in its frame as given [rad].
  void tellRotation(TimeNs t, bool inverted, const Vec3& turn);
  void retime(double by_s);
  /// All times of images that are kept.
  void shiftTimes(double by_s);
  double timeOffsetSigma() const;
  double focalPx() const { return 0.5 * (given.camera.fx + given.camera.fy); }
  void rememberPose(const State& s);
  void tellTiming(double by_s);
  void leaveOutWrongTracks(Packet* packet);
  void clockSetBack();
  void dropOldReadings();
  /// How far the accelerometer's gain, as found, is from what was given, in sigmas of its prior.
  double gainBeyondPrior(const Calibration& found) const;
  bool coveredByReadings(TimeNs t) const;
  void updateOrStart(const Packet& packet, StateEstimate* out);
  void tryStart(const vision::TrackedFrame& frame, StateEstimate* out);
  void update(const vision::TrackedFrame& frame, StateEstimate* out);
  /// Readings are missing before `t` (or not any more); said once per stretch (imu_hole.cpp).
  void noteHole(bool gap, TimeNs previous, TimeNs t);
  /// What the tracks alone say, where readings are missing.
  void guessAcrossHole(const State& previous, const vision::TrackedFrame& frame,
                       State* predicted) const;
  /// Is the last hole behind, and with it the hold on the landmarks? Told once.
  bool lostInHole(const vision::TrackedFrame& frame, TimeNs t);
  /// What the sights say where they contradict the readings before `frame` (false_readings.cpp).
  std::optional<window::Resected> contradiction(const State& previous,
                                                const vision::TrackedFrame& frame,
                                                const Pose& predicted);
  bool hangs(const State& previous, const vision::TrackedFrame& frame) const;
  /// Do they? Then `predicted` is what the sights say. A burst of readings only: not for long.
  bool contradicted(const State& previous, const vision::TrackedFrame& frame,
                    const std::optional<window::Resected>& seen, State* predicted);
  imu::Preintegration linkBySight(const State& previous, const State& seen) const;
  /// Is what contradicts the readings an image that was taken at another time (wrong_stamps.cpp)?
  /// It is counted, and the first one told.
  bool wronglyStamped(const vision::TrackedFrame& frame, const State& predicted,
                      const std::optional<window::Resected>& seen);
  /// When it was taken after its stamp [s], where that explains sights that are `off_px` off.
  std::optional<double> stampIsOffBy(const vision::TrackedFrame& frame, const State& predicted,
                                     double off_px);
  /// In O, by the readings alone; beyond `newest`, where they lead, as if the motion went on.
  std::optional<Pose> poseByReadings(TimeNs t, const State& newest);
  /// The state of an image that does not get into the window.
  void leaveOut(const State& predicted, StateEstimate* out) const;
  /// An image was taken so much later than stamped: where all scatter, the sights are believed less
  /// along their way, and that is told once.
  void noteLateness(double late_s);
  /// Says once that the images have the lens otherwise than given.
  void tellLens();
  void rememberSights(const vision::TrackedFrame& frame);
  /// Of a keyframe, for who asked for them.
  void tellSights(const vision::TrackedFrame& frame, TimeNs t_image);
  void updateRest(const vision::TrackedFrame& frame);
  std::string failure(const vision::TrackedFrame& frame, const window::SolveSummary& solve,
                      TimeNs t);
  void restart(const std::string& why);
  static FollowedPose followed(const window::LongNode& node);
  void collectRetired();

  /// Ranges up to the newest frame's time are judged and hung on it. States in O.
  void attachRanges(const State& previous, const State& newest);
  /// Ranges held by the keyframes of both windows, `motion` being the antenna in W.
  std::vector<window::HeldRange> heldRanges(std::uint64_t key) const;
  std::vector<window::HeldRange> heldDifferences() const;
  void updateAnchors(TimeNs t);
  void startLongWindow();
  State inWorld(const State& s) const;
  /// Metres of O per metre of W.
  double odometryScale() const { return std::exp(long_window.head().x[4]); }
  void collectRangeWarnings() {
    for (const std::string& w : ranges.takeWarnings()) warnings.push_back(w);
  }
  Eigen::Matrix<double, 6, 6> covarianceInWorld() const;
  std::vector<State> keyframes() const;
  std::vector<FollowedPose> followedInWindows() const;
  std::vector<Landmark> landmarks() const;
  void warn(const std::string& text) {
    log(log_sink, LogLevel::warning, text);
    warnings.push_back(text);
  }

  /// Tracks that were found to be wrong in a packet.
  struct WrongTracks {
    long packet = 0;
    std::vector<std::uint64_t> ids;
  };

  /// Of the newest state's image.
  struct Sights {
    TimeNs t = 0;
    std::vector<initialization::AlignmentSight> of;
  };

  const EstimatorConfig& config;
  LogSink log_sink;
  std::unique_ptr<Startup> startup;
  std::unique_ptr<window::ShortWindow> window;
  Pose T_B_C;         // as used until a window has its own
  Calibration given;  // as the recording and the settings say
  imu::ImuBuffer imu;
  RestDetector rest;
  window::LongWindow long_window;
  RangeLayer ranges;
  std::vector<StateEstimate> results;
  std::vector<KeyframeSights> sights;
  Doubts doubts;
  Elapsed elapsed;
  OldKeyframes old_keyframes;
  ThinnedOut<Landmark> old_landmarks{30000};  // 2 MB at most
  std::vector<std::string> warnings;
  std::map<std::string, double> wait_reasons;  // seconds
  std::deque<WrongTracks> wrong_tracks;        // that the tracker may not have heard of
  long packets = 0;
  long imu_gaps = 0;
  long imu_contradicted = 0;      // images whose readings were left out
  TimeNs contradicted_since = 0;  // 0: they fit
  long images_misstamped = 0;     // left out
  int wrong_stamps_in_a_row = 0;
  Vec3 turning_B = Vec3::Zero();  // before the newest state [rad/s]
  std::optional<Vec3> turning_C;  // of the camera, while they do not fit [rad/s]
  double usual_off_px = 0;        // how far sights are from where readings put them
  StampJitter stamp_jitter;
  std::unique_ptr<CameraTiming> timing;
  imu::ImuNoise imu_noise;         // as given, or as seen at rest
  int images_since_rotation = 0;   // was looked for
  double epipolar_px = 0;          // see vision::RigTracker
  bool turned = false;             // the camera's rotation is not as given
  bool pose_unknown = false;       // nobody gave the camera's pose in the body
  double time_offset_s = 0;        // images are stamped with it
  std::deque<StampedPose> recent;  // in O, while the timing is open
  Pose origin;                     // where the next segment starts
  bool running = false;
  int segment = 0;                      // grows with every restart
  std::vector<Eigen::Vector2f> pixels;  // of the features of the last image
  Sights last_sights;
  bool in_gap = false;  // warn once per stretch
  bool lens_told = false, jitter_told = false;
  TimeNs last_image = 0;  // on the IMU clock
  TimeNs last_usable = 0;
  /// Images at the ends of the last stretch without readings; none once it has been judged.
  struct Hole {
    TimeNs from = 0, to = 0;
  } hole;
  TimeNs last_seen = 0;  // last time landmarks held the pose
};

}  // namespace vir::estimator
