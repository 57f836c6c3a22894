#include "vir/estimator/loop_run.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "loop_worker.h"

namespace vir::estimator {
namespace {

/// Images that wait for their state: more than ever do (the estimator gives up at fewer).
constexpr std::size_t kMostKept = 120;
/// Images before the first pose: the estimator begins with keyframes of about 2 s.
constexpr std::size_t kMostEarly = 60;
/// Of a keyframe against its image, whose clock is known by then only about [s].
constexpr double kSameImage_s = 0.005;

/// A Mat that owns its pixels shares them; others are of somebody whose pixels do not last.
cv::Mat lasting(const cv::Mat& gray) { return gray.u != nullptr ? gray : gray.clone(); }

bool sameFile(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return std::filesystem::equivalent(a, b, ignored);
}

/// Anchors that hold the path.
long holding(const std::vector<Anchor>& anchors) {
  return std::count_if(anchors.begin(), anchors.end(), [](const Anchor& a) {
    return a.state == AnchorState::estimated || a.state == AnchorState::fixed;
  });
}

}  // namespace

void describeUse(OptionVisitor& v, LoopSettings& o) {
  v.value("loops", o.use,
          "look for places that were seen before, and correct the path by them (docs/loops.md)");
}

void describe(OptionVisitor& v, LoopSettings& o) {
  v.section("Loops", "Second visits that may be believed");
  v.value("map", o.map,
          "map of an earlier run, in whose frame this one is to go on; --map goes before it");
  v.value("save_map", o.save_map, "map to write at the end; --save-map goes before it");
  mission::describe(v, o.options);
}

LoopRun::LoopRun(const LoopSettings& settings, LogSink log, LoopTiming timing)
    : settings_(settings), log_(std::move(log)), timing_(timing), pace_(settings.options) {
  settings_.options.validate();
  if (!settings_.map.empty()) loadMap(settings_.map);
}
LoopRun::~LoopRun() = default;

void LoopRun::loadMap(const std::string& file) {
  if (map_) throw std::logic_error(file + ": there is a map already, " + map_file_);
  map_ = mission::loadMap(file);
  map_file_ = file;
  if (worker_) begin();
}

void LoopRun::setCamera(const Calibration& calibration) {
  worker_ =
      std::make_unique<LoopWorker>(settings_.options, calibration, timing_ != LoopTiming::at_once,
                                   timing_ == LoopTiming::in_a_thread);
  if (map_) begin();
}

void LoopRun::begin() {
  try {
    const auto loops = worker_->open();
    loops.closer.begin(*map_);
    found_ = loops.closer.found();
    map_->keyframes.clear();  // the closer has them, as many as it may
  } catch (const std::invalid_argument& e) {
    map_.reset();
    throw std::runtime_error(map_file_ + ": " + e.what());
  }
}

void LoopRun::keep(TimeNs t, const cv::Mat& gray) {
  if (gray.empty()) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  kept_.push_back({t, lasting(gray)});
  if (kept_.size() > kMostKept) kept_.pop_front();
}

cv::Mat LoopRun::release(TimeNs t) {
  const std::lock_guard<std::mutex> lock(mutex_);
  cv::Mat out;
  while (!kept_.empty() && kept_.front().t <= t) {
    if (kept_.front().t == t) out = kept_.front().gray;
    kept_.pop_front();
  }
  return out;
}

void LoopRun::keepEarly(TimeNs t, const cv::Mat& gray) {
  if (!worker_ || !pace_.searches(found_) || gray.empty()) return;
  early_.push_back({t, lasting(gray)});
  if (early_.size() > kMostEarly) early_.pop_front();
}

void LoopRun::lookBack(const StateEstimate& first, const VisualInertialEstimator& estimator) {
  const TimeNs offset = first.state.t - first.t_image;
  auto image = early_.begin();
  std::optional<TimeNs> begin;
  for (const State& s : estimator.keyframes()) {
    if (s.t >= first.state.t) break;
    const TimeNs t_image = s.t - offset;
    while (image != early_.end() && toSeconds(t_image - image->t) > kSameImage_s) ++image;
    if (image == early_.end()) break;
    if (toSeconds(image->t - t_image) > kSameImage_s) continue;
    if (!begin) begin = s.t;
    StateEstimate e = first;
    e.t_image = image->t;
    e.state = s;
    // What is not known of the scale grows with the way since the first of them.
    const double share = toSeconds(s.t - *begin) / toSeconds(first.state.t - *begin);
    e.covariance *= share * share;
    see(e, {}, image->gray, estimator);
  }
  early_.clear();
}

void LoopRun::see(const StateEstimate& estimate, const KeyframeSights& sights, const cv::Mat& gray,
                  const VisualInertialEstimator& estimator) {
  if (gray.empty() || !pace_.wants(estimate, found_)) return;
  pace_.took(estimate);
  LoopJob job;
  job.gray = gray;
  job.seen.gray = {estimate.t_image, gray.cols, gray.rows, gray.data, gray.step[0]};
  job.seen.estimate = estimate;
  for (const auto& s : sights.of) job.seen.landmarks.push_back({s.px, s.inverse_distance, s.sigma});
  job.seen.segment_since = segment_since_;
  std::vector<Anchor> anchors = estimator.anchors();
  job.seen.held = holding(anchors) > 0;
  job.seen.turn_held = holding(anchors) > 1;
  if (!found_) job.anchors = std::move(anchors);
  job.settled = std::exchange(settled_, {});
  job.followed = estimator.followed();
  worker_->give(std::move(job), image_);
}

void LoopRun::hear(LoopAnswer answer, std::vector<Revision>* revisions) {
  for (const auto& [level, text] : answer.said) log(log_, level, text);
  correction_ = answer.correction;
  found_ = answer.found;
  if (answer.revision) revisions->push_back(std::move(*answer.revision));
}

void LoopRun::tellFound(TimeNs t, LoopedOutput* out) {
  if (!map_ || !found_ || told_found_) return;
  told_found_ = true;
  out->frame_changes.push_back({t, correction_.T_M_W.pose()});
}

LoopedOutput LoopRun::take(VisualInertialEstimator* estimator, TimeNs t, const cv::Mat* gray) {
  LoopedOutput out;
  out.states = estimator->take();
  out.ranges = estimator->takeRanges();
  for (const FollowedPose& k : estimator->takeSettled()) settled_.push_back(k);
  const std::vector<KeyframeSights> all = estimator->takeSights();
  auto sights = all.begin();
  for (StateEstimate& e : out.states) {
    ++image_;
    const cv::Mat kept = release(e.t_image);
    const cv::Mat& image = gray != nullptr && e.t_image == t ? *gray : kept;
    if (e.segment != segment_) segment_since_ = e.state.t;
    segment_ = e.segment;
    if (!e.valid) keepEarly(e.t_image, image);
    if (!e.valid || !worker_) continue;
    if (!early_.empty()) lookBack(e, *estimator);
    out.uncorrected.push_back({e.state.t, e.state.T_W_B});
    newest_ = e.state.t;
    while (sights != all.end() && sights->t_image < e.t_image) ++sights;
    if (sights != all.end() && sights->t_image == e.t_image) {
      see(e, *sights, image, *estimator);
    } else if (pace_.searches(found_)) {
      see(e, {}, image, *estimator);
    }
    while (auto answer = worker_->take(image_)) hear(std::move(*answer), &out.revisions);
    tellFound(e.state.t, &out);
    correction_.apply(&e);
  }
  for (Revision& r : last_revisions_) out.revisions.push_back(std::move(r));
  if (finished_) tellFound(newest_ + 1, &out);  // by answers that came at the end
  last_revisions_.clear();
  const bool done = !out.states.empty() && out.states.back().t_image >= t;
  if (gray != nullptr && !done) keep(t, *gray);
  return out;
}

void LoopRun::finish(const VisualInertialEstimator& estimator) {
  finished_ = true;
  if (worker_) {
    while (auto answer = worker_->takeAny()) hear(std::move(*answer), &last_revisions_);
    const auto loops = worker_->open();
    loops.path.settle(std::exchange(settled_, {}));
    loops.closer.solve(loops.path.with(estimator.followed()), true);
    hear({loops.closer.now(), loops.closer.found(), loops.closer.takeRevision(),
          std::exchange(loops.said, {})},
         &last_revisions_);
    if (!found_) log(log_, LogLevel::warning, notFound());
  }
  if (settings_.save_map.empty() || saved_) return;
  saved_ = true;
  const mission::MissionMap map = mapNow(estimator);
  if (!found() && sameFile(settings_.save_map, map_file_)) {
    not_saved_ =
        "the map " + settings_.save_map +
        " stays as it was: the run was not found in it, and what it saw is not written over "
        "it (give --save-map another file for that)";
  } else if (map.keyframes.empty()) {
    not_saved_ = nothingToSave();
  }
  if (!not_saved_.empty()) {
    log(log_, LogLevel::warning, not_saved_);
    return;
  }
  mission::saveMap(map, settings_.save_map);
  log(log_, LogLevel::info, "map written: " + settings_.save_map);
}

void LoopRun::saveMap(const VisualInertialEstimator& estimator, const std::string& file) const {
  if (!worker_)
    throw std::runtime_error(file + ": no map can be written before the camera is known");
  mission::saveMap(mapNow(estimator), file);
}

mission::MissionMap LoopRun::mapNow(const VisualInertialEstimator& estimator) const {
  if (!worker_) return {};
  return worker_->open().closer.map(estimator.calibration(), anchors(estimator.anchors()));
}

std::vector<StampedPose> LoopRun::keyframes(const VisualInertialEstimator& estimator) const {
  FollowedPath alone;
  if (!worker_) {
    alone.settle(settled_);
    const auto all = alone.with(estimator.followed());
    return {all.begin(), all.end()};
  }
  const auto loops = worker_->open();
  FollowedPath path = loops.path;
  path.settle(settled_);
  const std::vector<FollowedPose> followed = path.with(estimator.followed());
  std::vector<StampedPose> out(followed.begin(), followed.end());
  for (StampedPose& k : out) k.T_W_B = loops.closer.correctionAt(k.t).pose() * k.T_W_B;
  return out;
}

std::vector<Anchor> LoopRun::anchors(std::vector<Anchor> in_W) const {
  const LevelTransform T_M_W = correction();
  const Mat3 R = rotZ(T_M_W.yaw_rad);
  for (Anchor& a : in_W) {
    a.p_W = T_M_W * a.p_W;
    a.mirror_p_W = T_M_W * a.mirror_p_W;
    if (a.waypoint_W) a.waypoint_W = T_M_W * *a.waypoint_W;
    a.covariance = R * a.covariance * R.transpose();
  }
  return in_W;
}

std::optional<SurveyFit> LoopRun::survey(std::optional<SurveyFit> of_W) const {
  if (of_W) of_W->T_S_W = of_W->T_S_W * correction().inverse();
  return of_W;
}

std::vector<Landmark> LoopRun::landmarks(const VisualInertialEstimator& estimator) const {
  if (worker_) {
    const auto loops = worker_->open();
    if (loops.closer.acts()) return loops.closer.landmarks();
  }
  return estimator.landmarks();
}

std::string LoopRun::notFound() const {
  return "the run was not found in the map " + map_file_ +
         ": its results are in a frame of their own";
}

std::string LoopRun::nothingToSave() const {
  std::error_code ignored;
  const bool there = std::filesystem::exists(settings_.save_map, ignored);
  return "the map " + settings_.save_map +
         " is not written: the run saw no place (too short, or no images with a pose)" +
         (there ? "; the file of that name stays as it was" : "");
}

std::vector<LoopRecord> LoopRun::records() const {
  return worker_ ? worker_->open().closer.records() : std::vector<LoopRecord>();
}

std::vector<std::pair<std::string, long>> LoopRun::counters() const {
  return worker_ ? worker_->open().closer.counters() : std::vector<std::pair<std::string, long>>();
}

std::vector<std::string> LoopRun::warnings() const {
  std::vector<std::string> out;
  if (!found()) out.push_back(notFound());
  if (!not_saved_.empty()) out.push_back(not_saved_);
  return out;
}

}  // namespace vir::estimator
