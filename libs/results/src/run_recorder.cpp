#include "vir/results/run_recorder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "csv_text.h"
#include "frame_history.h"
#include "long_run.h"
#include "loop_recorder.h"
#include "range_recorder.h"
#include "report_html.h"
#include "run_figures.h"
#include "survey_files.h"
#include "thumbnails.h"
#include "vir/evaluation/figure_parts.h"
#include "vir/evaluation/leaps.h"
#include "vir/evaluation/nees.h"
#include "vir/geometry/finite_pose.h"
#include "vir/results/calibration_yaml.h"
#include "vir/results/scene_file.h"

namespace vir::results {
namespace {

using namespace csv;

constexpr const char* kFramesHeader =
    "t_s,valid,health,segment,keyframe,tracks,landmarks,ms_pyramid,ms_flow,ms_detect,"
    "ms_initialise,ms_optimise,ms_marginalise,ms_total,vx_m_s,vy_m_s,vz_m_s,bgx_rad_s,bgy_rad_s,"
    "bgz_rad_s,bax_m_s2,bay_m_s2,baz_m_s2,sigma_x_m,sigma_y_m,sigma_z_m,sigma_rx_rad,sigma_ry_rad,"
    "sigma_rz_rad,reprojection_rms,inertial_rms,time_offset_s,fx_px,fy_px,cx_px,cy_px,cam_x_m,"
    "cam_y_m,cam_z_m,cam_rx_rad,cam_ry_rad,cam_rz_rad";

/// Upper triangle, row by row: position in W (p), rotation on the right (r).
constexpr const char* kCovarianceHeader =
    "t_s,px_px,px_py,px_pz,px_rx,px_ry,px_rz,py_py,py_pz,py_rx,py_ry,py_rz,pz_pz,pz_rx,pz_ry,pz_rz,"
    "rx_rx,rx_ry,rx_rz,ry_ry,ry_rz,rz_rz";

std::string columns(const Vec3& v) {
  return format(",%.6g,%.6g,%.6g", clean(v.x()), clean(v.y()), clean(v.z()));
}

std::string frameLine(const StateEstimate& e) {
  const StageTimes& ms = e.ms;
  std::string line =
      evaluation::formatSeconds(e.state.t) + (e.valid ? ",1," : ",0,") + csvWord(healthText(e));
  line += format(",%d,%d,%d,%d", e.segment, e.keyframe ? 1 : 0, e.tracks, e.landmarks);
  for (const double v :
       {ms.pyramid, ms.flow, ms.detect, ms.initialise, ms.optimise, ms.marginalise, ms.total}) {
    line += format(",%.3f", clean(v));
  }
  line += columns(e.state.v) + columns(e.state.bg) + columns(e.state.ba);
  const Eigen::Matrix<double, 6, 1> variance = e.covariance.diagonal();
  for (int i = 0; i < 6; ++i) line += format(",%.6g", std::sqrt(std::max(0.0, clean(variance[i]))));
  const Calibration& c = e.calibration;
  line += format(",%.4g,%.4g,%.7f", clean(e.reprojection_rms), clean(e.inertial_rms),
                 clean(c.time_offset_s));
  line += format(",%.3f,%.3f,%.3f,%.3f", clean(c.camera.fx), clean(c.camera.fy), clean(c.camera.cx),
                 clean(c.camera.cy));
  return line + columns(c.T_B_C.p) + columns(logQuat(c.T_B_C.q));
}

std::string covarianceLine(const StateEstimate& e) {
  std::string line = evaluation::formatSeconds(e.state.t);
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) line += format(",%.9g", clean(e.covariance(r, c)));
  }
  return line;
}

/// Position and yaw aligned errors; empty where there is nothing to compare.
std::optional<evaluation::EvaluationResult> compare(const Trajectory& truth,
                                                    const Trajectory& estimate) {
  if (truth.size() < 3 || estimate.size() < 3) return std::nullopt;
  try {
    evaluation::EvaluationOptions options;
    options.distances_m = {10};
    options.rpe_time_s = 1;
    return evaluation::evaluate(truth, estimate, options);
  } catch (const evaluation::EvaluationError&) {
    return std::nullopt;  // no overlap in time: the summary then has no ATE
  }
}

/// Of compare().
void relativeErrors(const evaluation::EvaluationResult& result, RunSummary* summary) {
  if (result.rpe_time.translation_m.count > 0) {
    summary->rpe_1s_m = result.rpe_time.translation_m.rmse;
    summary->rpe_1s_deg = result.rpe_time.rotation_deg.rmse;
  }
  if (!result.rpe_distance.empty() && result.rpe_distance.front().translation_m.count > 0) {
    summary->rpe_10m_m = result.rpe_distance.front().translation_m.rmse;
    summary->rpe_10m_deg = result.rpe_distance.front().rotation_deg.rmse;
  }
}

}  // namespace

RunRecorder::RunRecorder(const ResultsFolder& folder, LogSink log)
    : folder_(folder),
      log_(std::move(log)),
      trajectory_file_(folder.file("trajectory.tum")),
      covariance_file_(folder.file("trajectory_covariance.csv")),
      frames_file_(folder.file("frames.csv")),
      ranges_(std::make_unique<RangeRecorder>(folder)),
      loops_(std::make_unique<LoopRecorder>(folder)),
      long_run_(std::make_unique<LongRun>(folder.path())),
      history_(std::make_unique<FrameHistory>()),
      images_(std::make_unique<Thumbnails>()) {
  frames_file_.line(kFramesHeader);
  covariance_file_.line(kCovarianceHeader);
}

RunRecorder::~RunRecorder() = default;

void RunRecorder::onObservation(const mrpt::obs::CObservation& observation) {
  images_->see(observation);
}

void RunRecorder::onOutput(const roles::EstimatorOutput& output,
                           const roles::Estimator& estimator) {
  to_come_.insert(to_come_.end(), output.frame_changes.begin(), output.frame_changes.end());
  for (const StateEstimate& estimate : output.states) add(estimate);
  if (!output.states.empty()) images_->add(output.states.back(), estimator.trackedPixels());
  for (const RangeRecord& range : output.ranges) ranges_->add(range);
  for (const Revision& revision : output.revisions) add(revision);
  for (const StampedPose& keyframe : output.settled) keepSettled(keyframe);
  for (const roles::CalibrationPoint& point : output.calibrations) {
    long_run_->calibrations.add(point);
  }
  for (const StampedPose& pose : output.uncorrected) loops_->add(pose);
}

void RunRecorder::add(const Revision& revision) {
  for (const StampedPose& k : revision.keyframes) revised_[k.t] = k.T_W_B;
}

void RunRecorder::keepSettled(const StampedPose& keyframe) {
  revised_.erase(keyframe.t);
  long_run_->settled.add(rowOf(keyframe));
}

void RunRecorder::add(const StateEstimate& estimate) {
  frames_file_.line(frameLine(estimate));
  if (!first_estimate_) first_estimate_ = estimate.state.t;
  history_->add(estimate);
  long_run_->cpu_ms.add({estimate.state.t, clean(estimate.ms.total)});
  if (estimate.segment != segment_) {
    vir::log(log_, LogLevel::warning,
             "segment " + std::to_string(estimate.segment) +
                 format(" starts at %.1f s: positions are not tied to those before",
                        toSeconds(estimate.state.t - *first_estimate_)));
    segment_ = estimate.segment;
  }
  if (estimate.valid) writePose(estimate);
}

void RunRecorder::writePose(const StateEstimate& estimate) {
  if (!isFinite(estimate.state.T_W_B)) {
    ++not_finite_;
    return;
  }
  if (last_pose_ && estimate.state.t <= last_pose_->t) {
    ++out_of_order_;
    return;
  }
  const StampedPose pose{estimate.state.t, estimate.state.T_W_B};
  while (!to_come_.empty() && to_come_.front().t <= pose.t) {
    add(to_come_.front());
    to_come_.erase(to_come_.begin());
  }
  if (last_pose_) path_m_ += (pose.T_W_B.p - last_pose_->T_W_B.p).norm();
  trajectory_file_.line(evaluation::tumLine(pose));
  covariance_file_.line(covarianceLine(estimate));
  last_pose_ = pose;
  EstimateRow row{rowOf(pose), {}};
  Eigen::Map<Mat3>(row.covariance) = estimate.covariance.topLeftCorner<3, 3>();
  long_run_->poses.add(row);
}

void RunRecorder::add(const FrameChange& change) {
  frame_changes_.push_back(change);
  if (!last_pose_) return;
  last_pose_->T_W_B = change.T_new_old * last_pose_->T_W_B;
  trajectory_file_.line(evaluation::frameChangeLine(change.T_new_old));
  history_->changeFrame(change.T_new_old);
}

void RunRecorder::addGroundTruth(TimeNs t, const Pose& T_W_B) {
  if (!isFinite(T_W_B) || (long_run_->truth.size() > 0 && t <= last_truth_)) return;
  last_truth_ = t;
  long_run_->truth.add(rowOf({t, T_W_B}));
}

/// At the end: everything is needed at once.
void RunRecorder::fetchLongRun() {
  for (const EstimateRow& row : long_run_->poses.all()) {
    StampedPose pose = poseOf(row.pose);
    Mat3 covariance = Eigen::Map<const Mat3>(row.covariance);
    for (const FrameChange& change : frame_changes_) {
      if (pose.t >= change.t) continue;
      const Mat3 R = change.T_new_old.R();
      pose.T_W_B = change.T_new_old * pose.T_W_B;
      covariance = R * covariance * R.transpose();
    }
    trajectory_.push_back(pose);
    position_covariance_.push_back(covariance);
    const double variance = clean(position_covariance_.back().trace());
    position_sigma_m_.push_back(std::sqrt(std::max(0.0, variance)));
  }
  for (const PoseRow& row : long_run_->truth.all()) truth_.push_back(poseOf(row));
  for (const CpuRow& row : long_run_->cpu_ms.all()) cpu_ms_.emplace_back(row.t, row.ms);
}

void RunRecorder::checkGroundTruth(RunSummary* summary) {
  long left_out = 0;
  truth_ = evaluation::withoutLeaps(truth_, &left_out);
  if (left_out == 0) return;
  summary->counters.emplace_back("ground_truth_left_out", left_out);
  summary->warnings.push_back(evaluation::describeLeaps(left_out));
  vir::log(log_, LogLevel::warning, summary->warnings.back());
}

void RunRecorder::writeKeyframes(const std::vector<StampedPose>& keyframes) {
  std::map<TimeNs, Pose> all;
  for (const PoseRow& row : long_run_->settled.all()) all[row.t] = poseOf(row).T_W_B;
  for (const auto& [t, T_W_B] : revised_) all[t] = T_W_B;
  for (const StampedPose& k : keyframes) all[k.t] = k.T_W_B;
  for (const auto& [t, T_W_B] : all) {
    if (isFinite(T_W_B)) {
      smoothed_.push_back({t, T_W_B});
    } else {
      ++not_finite_;
    }
  }
  OutputFile file(folder_.file("trajectory_smoothed.tum"));
  evaluation::writeTum(file.stream(), smoothed_);
  file.close();
}

void RunRecorder::writeLandmarks(const std::vector<Landmark>& landmarks) {
  std::size_t count = 0;
  for (const Landmark& l : landmarks) count += l.p_W.allFinite() ? 1 : 0;
  OutputFile file(folder_.file("landmarks.ply"));
  file.line("ply\nformat ascii 1.0\nelement vertex " + std::to_string(count));
  file.line("property float x\nproperty float y\nproperty float z\nend_header");
  for (const Landmark& l : landmarks) {
    if (!l.p_W.allFinite()) continue;
    file.line(format("%.4f %.4f %.4f", l.p_W.x(), l.p_W.y(), l.p_W.z()));
  }
  file.close();
}

void RunRecorder::evaluateInto(RunSummary* summary) {
  evaluation_ = compare(truth_, trajectory_);
  if (evaluation_) {
    summary->ate_posyaw_m = evaluation_->ate_position_m.rmse;
    if (evaluation_->attitudes) summary->ate_posyaw_deg = evaluation_->ate_orientation_deg.rmse;
    relativeErrors(*evaluation_, summary);
    // A sparse truth is met between poses, where there is no covariance.
    if (!evaluation_->association.estimate_interpolated && evaluation_->attitudes) {
      errors_ = errorsFromStart();
      summary->nees_position = positionNees(errors_);
    }
    for (AnchorResult& a : summary->anchors) {
      const auto truth = true_anchors_.find(a.estimate.id);
      if (truth == true_anchors_.end() || !a.estimate.has_position) continue;
      const evaluation::AlignmentResult& T = evaluation_->transform;
      const Vec3 error = T.apply(Pose(Quat::Identity(), a.estimate.p_W)).p - truth->second;
      a.error_m = error.norm();
      a.error_horizontal_m = error.head<2>().norm();
    }
  }
  if (const auto smoothed = compare(truth_, smoothed_)) {
    summary->ate_smoothed_posyaw_m = smoothed->ate_position_m.rmse;
  }
}

std::vector<FrameError> RunRecorder::errorsFromStart() const {
  const bool leaps = !frame_changes_.empty();
  const auto in_M = worldAtStart(truth_, (smoothed_.empty() ? trajectory_ : smoothed_).front());
  // Until the run was found in a map its world was another one, which the leap did not mend.
  const auto in_W = leaps ? worldAtStart(truth_, trajectory_.front()) : in_M;
  if (!in_M || !in_W) return {};
  std::vector<FrameError> errors;
  for (const evaluation::PosePair& pair : evaluation_->association.pairs) {
    const bool before = leaps && pair.t < frame_changes_.back().t;
    const Pose truth = (before ? *in_W : *in_M) * pair.reference;
    errors.push_back(
        {pair.t, pair.estimate.p - truth.p, logQuat(truth.q.conjugate() * pair.estimate.q)});
  }
  return errors;
}

std::optional<double> RunRecorder::positionNees(const std::vector<FrameError>& errors) const {
  std::vector<double> values;
  std::size_t i = 0;
  for (const FrameError& error : errors) {
    while (i < trajectory_.size() && trajectory_[i].t < error.t) ++i;
    if (i == trajectory_.size()) break;
    double value = 0;
    if (evaluation::nees(error.p, position_covariance_[i], &value)) values.push_back(value);
  }
  if (values.empty()) return std::nullopt;
  return evaluation::meanNeesPerDof(values, 3);
}

void RunRecorder::summariseRanges(RunSummary* summary) const {
  summary->ranges_accepted = ranges_->accepted();
  summary->ranges_collected = ranges_->collected();
  summary->ranges_rejected = ranges_->rejected();
  summary->ranges_before_start = ranges_->beforeStart();
  const auto counters = ranges_->counters();
  summary->counters.insert(summary->counters.end(), counters.begin(), counters.end());
}

/// Of the anchors: results in its frame, and what is wrong with it.
void RunRecorder::takeSurvey(const roles::Estimator& estimator, RunSummary* summary) {
  summary->survey = estimator.survey();
  if (!summary->survey) return;
  writeSurveyFiles(folder_, *summary->survey, trajectory_, smoothed_);
  for (const std::string& line : surveyWarnings(*summary->survey)) {
    vir::log(log_, LogLevel::warning, line);
    summary->warnings.push_back(line);
  }
  if (summary->survey->status != SurveyStatus::contradicted) return;
  summary->doubts.push_back("the survey of the anchors is wrong: " + summary->survey->reason);
}

void RunRecorder::onEnd(const roles::Estimator& estimator, RunSummary* summary) {
  trajectory_file_.close();
  covariance_file_.close();
  frames_file_.close();
  fetchLongRun();
  const std::vector<Anchor> anchors = estimator.anchors();
  ranges_->finish(anchors);
  for (const Anchor& a : anchors) {
    const auto named = texts_.find(a.id);
    summary->anchors.push_back({a, {}, {}, named == texts_.end() ? std::string() : named->second});
  }
  summariseRanges(summary);
  summary->loops = loops_->finish(estimator.loops());
  writeKeyframes(estimator.keyframes());
  std::vector<Landmark> landmarks = estimator.landmarks();
  writeLandmarks(landmarks);
  summary->poses = static_cast<long>(trajectory_.size());
  summary->path_m = path_m_;
  if (!trajectory_.empty()) summary->init_time_s = toSeconds(trajectory_.front().t - first_frame_);
  if (!frame_changes_.empty()) {
    summary->in_map_s = toSeconds(frame_changes_.back().t - first_frame_);
  }
  if (not_finite_ > 0) summary->counters.emplace_back("poses_not_finite", not_finite_);
  if (out_of_order_ > 0) summary->counters.emplace_back("poses_out_of_order", out_of_order_);
  takeSurvey(estimator, summary);
  fillVerdict(summary, explain_);
  if (summary->calibration && summary->calibration_sigma) {
    OutputFile file(folder_.file("calibration.yaml"));
    file.line(calibrationYaml(*summary->calibration, *summary->calibration_sigma,
                              summary->further_labels, summary->further_sigma));
    file.close();
  }
  checkGroundTruth(summary);
  evaluateInto(summary);
  writePictures(anchors, landmarks, *summary);
  if (trajectory_.empty()) return;
  std::vector<SceneRobot> robots(1);  // after hours of many megabytes: none is there twice
  SceneRobot& robot = robots.front();
  robot = {"", evaluation::figureColor(0), Pose(), trajectory_, anchors, std::move(landmarks)};
  if (evaluation_) robot.truth = evaluation::inWorldOfEstimate(truth_, *evaluation_);
  robot.camera = summary->calibration;
  robot.loops = loops_->records();
  writeScene(folder_.file("scene.3Dscene"), robots);
}

void RunRecorder::writePictures(const std::vector<Anchor>& anchors,
                                const std::vector<Landmark>& landmarks,
                                const RunSummary& summary) const {
  const RunPictures pictures{first_frame_,
                             trajectory_,
                             smoothed_,
                             truth_,
                             evaluation_,
                             position_sigma_m_,
                             cpu_ms_,
                             anchors,
                             true_anchors_,
                             ranges_->sample(),
                             long_run_->calibrations.values(),
                             summary.calibration_given,
                             loops_->records()};
  if (!trajectory_.empty())
    writeTextFile(folder_.file("map.svg"), evaluation::toSvg(mapFigure(pictures)));
  const evaluation::Figure ranges = rangesFigure(pictures);
  if (!ranges.panels.empty()) writeTextFile(folder_.file("ranges.svg"), evaluation::toSvg(ranges));
  writeTextFile(folder_.file("report.html"),
                reportHtml(summary, {pictures, *history_, errors_, images_->kept(), landmarks}));
}

}  // namespace vir::results
