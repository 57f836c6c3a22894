#include "vir_estimator.h"

#include <mrpt/math/CMatrixFixed.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>
#include <mrpt/poses/CPose3DQuat.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cstdio>
#include <utility>

#include "bias_model_file.h"
#include "vir/rawlog/anchor_ranges.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/mrpt_camera.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/range_differences.h"
#include "vir/roles/range_labels.h"

namespace vir {
void VirSettings::describe(OptionVisitor& v) {
  v.section("Estimator", "The estimator and which sensors of the recording it reads");
  v.value("camera_label", camera_label, "sensor label of the images");
  v.value("other_cameras", other_cameras,
          "sensor labels of further cameras of the robot, with blanks between; auto: CAM1 to CAM7, "
          "where there are any; none: one camera");
  v.value("tracks_label", tracks_label,
          "sensor label of feature tracks, for a recording without images");
  v.value("imu_label", imu_label, "sensor label of the IMU");
  v.value("range_label", range_label,
          "sensor label of the ranges to anchors; several with blanks between: antennas of the "
          "robot, each with its place on it in the recording");
  v.value("use_ranges", config.ranges.use, "use the ranges, if the recording has any");
  v.value("pipelined", config.pipelined,
          "the tracker hears of the state one image later, as it does with two threads in record");
  estimator::describeUse(v, loops);
  window::describeMode(v, config.long_window);
  window::describeCalibrate(v, config.window);
  estimator::describe(v, config);
  v.section("Camera", "What the recording does not say about the camera");
  v.value("other_time_offsets_s", other_time_offsets_s, 0,
          "time_offset_s of the further cameras, in their order; of those not given: as of the "
          "first");
  estimator::describe(v, loops);
}

std::vector<roles::EstimatorInput> VirSettings::inputs() const {
  using roles::InputKind;
  std::vector<roles::EstimatorInput> out{{InputKind::image, camera_label, 1},
                                         {InputKind::tracks, tracks_label, 1},
                                         {InputKind::imu, imu_label, 2}};
  const bool named = other_cameras != "auto";
  for (const std::string& label : otherCameraLabels()) {
    out.push_back({InputKind::image, label, 0, named});
  }
  roles::addRangeInputs(range_label, &out);
  return out;
}

bool VirSettings::workBehind() {
  config.pipelined = true;
  return true;
}

std::unique_ptr<roles::Estimator> VirSettings::create(const LogSink& log,
                                                      std::function<void()> on_estimates) const {
  requireOtherCameras();
  return std::make_unique<VirEstimator>(*this, log, std::move(on_estimates));
}

VirEstimator::VirEstimator(VirSettings settings, const LogSink& log,
                           std::function<void()> on_estimates)
    : settings_(std::move(settings)), log_(log), behind_(on_estimates != nullptr) {
  settings_.config.tell_sights = settings_.loops.use;
  estimator_ =
      std::make_unique<estimator::VisualInertialEstimator>(withFiles(settings_.config), log);
  if (settings_.loops.use) {
    using estimator::LoopTiming;
    const LoopTiming timing = behind_                      ? LoopTiming::in_a_thread
                              : settings_.config.pipelined ? LoopTiming::late
                                                           : LoopTiming::at_once;
    loops_ = std::make_unique<estimator::LoopRun>(settings_.loops, log, timing);
  }
  if (on_estimates) estimator_->workBehind(std::move(on_estimates));
  cameras_.push_back({settings_.camera_label, true, false, {}, 0, 0, 0});
  for (const std::string& label : settings_.otherCameraLabels()) {
    cameras_.push_back({label, false, false, {}, 0, 0, 0});
  }
  rig_started_ = cameras_.size() == 1;
}

void VirEstimator::warnOnce(const std::string& key, const std::string& text) {
  if (std::find(warned_.begin(), warned_.end(), key) != warned_.end()) return;
  warned_.push_back(key);
  warnings_.push_back(text);
  log(log_, LogLevel::warning, text);
}

void VirEstimator::add(const mrpt::obs::CObservation& observation) {
  Camera* camera = cameraOf(observation.sensorLabel);
  const auto* image = dynamic_cast<const mrpt::obs::CObservationImage*>(&observation);
  if (camera != nullptr && image != nullptr) {
    addImage(*image, camera);
  } else if (observation.sensorLabel == settings_.tracks_label) {
    using Tracks = mrpt::obs::CObservationStereoImagesFeatures;
    if (const auto* tracks = dynamic_cast<const Tracks*>(&observation)) addTracks(*tracks);
  } else if (observation.sensorLabel == settings_.imu_label) {
    if (const auto* imu = dynamic_cast<const mrpt::obs::CObservationIMU*>(&observation)) {
      addImu(*imu);
    }
  } else if (roles::isAmong(observation.sensorLabel, settings_.range_label)) {
    for (const Range& r : rawlog::rangesOf(observation)) {
      inTurn([this, r] { estimator_->addRange(r); });
    }
  } else if (const auto anchor = rawlog::deployedAnchorOf(observation)) {
    inTurn([this, a = *anchor] { estimator_->anchorDeployed(a.id, a.p_B, a.sigma_m); });
  } else {
    for (const Range& r : rawlog::rangeDifferencesOf(observation)) {
      inTurn([this, r] { estimator_->addRange(r); });
    }
    for (const AnchorRange& r : rawlog::anchorRangesOf(observation)) {
      inTurn([this, r] { estimator_->addAnchorRange(r); });
    }
  }
}

void VirEstimator::addImu(const mrpt::obs::CObservationIMU& o) {
  if (const auto sample = rawlog::imuSampleOf(o)) {
    imu_saturation_.add(*sample);
    inTurn([this, s = *sample] { estimator_->addImu(s); });
    return;
  }
  ++imu_incomplete_;
  warnOnce("imu",
           "IMU readings without all six of acceleration and angular rate are skipped; first at " +
               std::to_string(rawlog::fromMrptTime(o.timestamp)) + " ns");
}

bool VirEstimator::knowsCamera(const mrpt::img::TCamera& camera,
                               const mrpt::poses::CPose3D& T_B_C) {
  if (estimator_->hasCamera()) return true;
  calibration_ = rawlog::fromMrptCamera(camera);
  try {
    estimator_->setCamera(calibration_, rawlog::fromMrptPose(T_B_C));
    if (loops_) loops_->setCamera(estimator_->givenCalibration());
  } catch (const std::invalid_argument& e) {
    ++images_without_calibration_;
    warnOnce("calibration", std::string("images without a usable calibration are skipped (") +
                                e.what() +
                                "); set it with rawlog-edit --camera-params or import again");
    return false;
  }
  return true;
}

void VirEstimator::addFirstImage(TimeNs t, const cv::Mat& gray) {
  if (loops_ && behind_) loops_->keep(t, gray);
  estimator_->addImage(t, gray);
  if (loops_ && !behind_) pump(t, &gray);
}

void VirEstimator::addTracks(const mrpt::obs::CObservationStereoImagesFeatures& o) {
  if (any_image_) {
    warnOnce("tracks", "the recording holds images (" + settings_.camera_label +
                           ") and feature tracks (" + settings_.tracks_label +
                           "): the tracks are not used");
    return;
  }
  if (loops_ && settings_.loops.hasMaps()) {
    warnOnce("loops", "places are found by images: with feature tracks alone there are no maps");
  }
  if (!knowsCamera(o.cameraLeft, mrpt::poses::CPose3D(o.cameraPoseOnRobot))) return;
  startRig();
  if (!camera_) camera_ = camera::makeCamera(calibration_);
  estimator_->addTracks(track_reader_.read(o, *camera_));
}

void VirEstimator::finish() {
  startRig();
  estimator_->finish();
  if (!loops_) return;
  pump(0, nullptr);
  loops_->finish(*estimator_);
}

void VirEstimator::pump(TimeNs t, const cv::Mat* gray) {
  estimator::LoopedOutput more = loops_->take(estimator_.get(), t, gray);
  const auto append = [](auto* to, auto& from) { to->insert(to->end(), from.begin(), from.end()); };
  append(&waiting_.states, more.states);
  append(&waiting_.ranges, more.ranges);
  append(&waiting_.revisions, more.revisions);
  append(&waiting_.uncorrected, more.uncorrected);
  append(&waiting_.frame_changes, more.frame_changes);
}

roles::EstimatorOutput VirEstimator::take() {
  roles::EstimatorOutput out;
  if (loops_) {
    pump(0, nullptr);
    out = std::exchange(waiting_, {});
  } else {
    out.states = estimator_->take();
    out.ranges = estimator_->takeRanges();
    for (const FollowedPose& k : estimator_->takeSettled()) out.settled.push_back(k);
  }
  const auto sigma = estimator_->calibrationSigma();
  if (sigma && !out.states.empty() && out.states.back().valid) {
    out.calibrations.push_back({out.states.back().state.t, estimator_->calibration(), *sigma});
  }
  return out;
}

std::vector<Landmark> VirEstimator::landmarks() const {
  return loops_ ? loops_->landmarks(*estimator_) : estimator_->landmarks();
}

std::vector<StampedPose> VirEstimator::keyframes() const {
  if (loops_) return loops_->keyframes(*estimator_);
  std::vector<StampedPose> out;
  for (const State& s : estimator_->keyframes()) out.push_back({s.t, s.T_W_B});
  return out;
}

std::vector<Anchor> VirEstimator::anchors() const {
  return loops_ ? loops_->anchors(estimator_->anchors()) : estimator_->anchors();
}
std::optional<SurveyFit> VirEstimator::survey() const {
  return loops_ ? loops_->survey(estimator_->survey()) : estimator_->survey();
}
std::optional<std::vector<LoopRecord>> VirEstimator::loops() const {
  if (!loops_) return std::nullopt;
  return loops_->records();
}

std::vector<Eigen::Vector2f> VirEstimator::trackedPixels() const {
  return estimator_->trackedPixels();
}

roles::EstimatorReport VirEstimator::report() const {
  const estimator::EstimatorCounters c = estimator_->counters();
  const imu::ImuBufferCounters& i = estimator_->imuCounters();
  roles::EstimatorReport r;
  r.counters = {{"images", c.images},
                {"images_unusable", c.images_unusable},
                {"images_undecodable", cameras_.front().undecodable},
                {"images_without_calibration", images_without_calibration_},
                {"features_unusable", track_reader_.unusable()},
                {"images_out_of_order", c.images_out_of_order},
                {"images_without_imu", c.images_without_imu},
                {"images_misstamped", c.images_misstamped},
                {"image_gaps", c.image_gaps},
                {"bad_stamps", c.bad_stamps},
                {"imu_readings", i.accepted},
                {"imu_not_finite", i.not_finite},
                {"imu_out_of_order", i.out_of_order},
                {"imu_spikes", c.imu_spikes},
                {"imu_impossible", c.imu_impossible},
                {"imu_contradicted", c.imu_contradicted},
                {"imu_saturated", imu_saturation_.readings()},
                {"imu_incomplete", imu_incomplete_},
                {"imu_gaps", c.imu_gaps},
                {"clock_steps", c.clock_steps}};
  reportRig(c, &r);
  for (const auto& counter : estimator_->rangeCounters()) r.counters.push_back(counter);
  r.warnings = warnings_;
  if (loops_) {
    for (const auto& counter : loops_->counters()) r.counters.push_back(counter);
    for (const std::string& w : loops_->warnings()) r.warnings.push_back(w);
  }
  for (const std::string& w : estimator_->warnings()) r.warnings.push_back(w);
  if (c.imu_spikes + c.imu_impossible > 0) {
    r.warnings.push_back(std::to_string(c.imu_spikes + c.imu_impossible) +
                         " IMU readings were left out: single ones far from their neighbours (" +
                         std::to_string(c.imu_spikes) + ") or beyond what an IMU can read (" +
                         std::to_string(c.imu_impossible) + "); check its wiring and its driver");
  }
  if (imu_saturation_.readings() > 0) {
    char longest[32];
    std::snprintf(longest, sizeof longest, "%.3f", imu_saturation_.longestS());
    r.warnings.push_back(std::to_string(imu_saturation_.readings()) +
                         " IMU readings are at the end of the sensor's range, longest for " +
                         longest + " s (" + imu_saturation_.where() +
                         "): the motion beyond it is missing from the path; set the sensor to a "
                         "greater range, or damp its mounting");
  }
  r.resets = estimator_->resets();
  r.longest_wait_reason = estimator_->longestWaitReason();
  if (estimator_->hasCamera()) {
    r.doubts = estimator_->doubts();
    doubtRig(c, &r);
    r.calibration = estimator_->calibration();
    r.calibration_given = estimator_->givenCalibration();
    if (settings_.config.window.calibrate) {
      r.calibration_assumed = settings_.config.window.calibration;
    }
    r.calibration_sigma = estimator_->calibrationSigma();
    r.further_sigma = estimator_->furtherSigma();
    r.calibration_covariance = estimator_->calibrationCovariance();
  }
  return r;
}

}  // namespace vir
