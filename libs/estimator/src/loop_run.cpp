#include "vir/estimator/loop_run.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

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

LoopRun::LoopRun(const LoopSettings& settings, LogSink log)
    : settings_(settings), log_(std::move(log)) {
  settings_.options.validate();
  if (!settings_.map.empty()) loadMap(settings_.map);
}

void LoopRun::loadMap(const std::string& file) {
  if (map_) throw std::logic_error(file + ": there is a map already, " + map_file_);
  map_ = mission::loadMap(file);
  map_file_ = file;
  if (closer_) begin();
}

void LoopRun::setCamera(const Calibration& calibration) {
  closer_ = std::make_unique<mission::LoopCloser>(settings_.options, calibration, log_);
  if (map_) begin();
}

void LoopRun::begin() {
  try {
    closer_->begin(*map_);
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
  if (!closer_ || !closer_->searching() || gray.empty()) return;
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
  if (gray.empty() || !closer_->wants(estimate)) return;
  mission::SeenKeyframe seen;
  seen.gray = {estimate.t_image, gray.cols, gray.rows, gray.data, gray.step[0]};
  seen.estimate = estimate;
  for (const auto& s : sights.of) seen.landmarks.push_back({s.px, s.inverse_distance, s.sigma});
  seen.segment_since = segment_since_;
  const std::vector<Anchor> anchors = estimator.anchors();
  seen.held = holding(anchors) > 0;
  seen.turn_held = holding(anchors) > 1;
  if (!closer_->found()) closer_->setAnchors(anchors);
  closer_->add(seen);
  if (closer_->solveDue()) solve(estimator);
}

std::vector<FollowedPose> LoopRun::inWorld(const VisualInertialEstimator& estimator) const {
  std::vector<FollowedPose> out = settled_;
  for (const FollowedPose& k : estimator.followed()) {
    if (out.empty() || k.t > out.back().t) out.push_back(k);
  }
  return out;
}

void LoopRun::solve(const VisualInertialEstimator& estimator, bool last) {
  closer_->solve(inWorld(estimator), last);
}

LoopedOutput LoopRun::take(VisualInertialEstimator* estimator, TimeNs t, const cv::Mat* gray) {
  LoopedOutput out;
  out.states = estimator->take();
  out.ranges = estimator->takeRanges();
  for (const FollowedPose& k : estimator->takeSettled()) settled_.push_back(k);
  const std::vector<KeyframeSights> all = estimator->takeSights();
  auto sights = all.begin();
  for (StateEstimate& e : out.states) {
    const cv::Mat kept = release(e.t_image);
    const cv::Mat& image = gray != nullptr && e.t_image == t ? *gray : kept;
    if (e.segment != segment_) segment_since_ = e.state.t;
    segment_ = e.segment;
    if (!e.valid) keepEarly(e.t_image, image);
    if (!e.valid || !closer_) continue;
    if (!early_.empty()) lookBack(e, *estimator);
    out.uncorrected.push_back({e.state.t, e.state.T_W_B});
    while (sights != all.end() && sights->t_image < e.t_image) ++sights;
    if (sights != all.end() && sights->t_image == e.t_image) {
      see(e, *sights, image, *estimator);
    } else if (closer_->searching()) {
      see(e, {}, image, *estimator);
    }
    if (map_ && closer_->found() && !told_found_) {
      told_found_ = true;
      out.frame_changes.push_back({e.state.t, closer_->correction().pose()});
    }
    closer_->correct(&e);
    if (auto revision = closer_->takeRevision()) out.revisions.push_back(std::move(*revision));
  }
  if (last_revision_) out.revisions.push_back(*std::exchange(last_revision_, std::nullopt));
  const bool done = !out.states.empty() && out.states.back().t_image >= t;
  if (gray != nullptr && !done) keep(t, *gray);
  return out;
}

void LoopRun::finish(const VisualInertialEstimator& estimator) {
  if (closer_) {
    solve(estimator, true);
    last_revision_ = closer_->takeRevision();
    if (!closer_->found()) log(log_, LogLevel::warning, notFound());
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
  if (!closer_)
    throw std::runtime_error(file + ": no map can be written before the camera is known");
  mission::saveMap(mapNow(estimator), file);
}

mission::MissionMap LoopRun::mapNow(const VisualInertialEstimator& estimator) const {
  if (!closer_) return {};
  return closer_->map(estimator.calibration(), anchors(estimator.anchors()));
}

LevelTransform LoopRun::correction() const {
  return closer_ ? closer_->correction() : LevelTransform();
}

std::vector<StampedPose> LoopRun::keyframes(const VisualInertialEstimator& estimator) const {
  const std::vector<FollowedPose> followed = inWorld(estimator);
  std::vector<StampedPose> out(followed.begin(), followed.end());
  if (!closer_) return out;
  for (StampedPose& k : out) k.T_W_B = closer_->correctionAt(k.t).pose() * k.T_W_B;
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
  if (of_W && closer_) of_W->T_S_W = of_W->T_S_W * closer_->correction().inverse();
  return of_W;
}

std::vector<Landmark> LoopRun::landmarks(const VisualInertialEstimator& estimator) const {
  return closer_ && closer_->acts() ? closer_->landmarks() : estimator.landmarks();
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
  return closer_ ? closer_->records() : std::vector<LoopRecord>();
}

std::vector<std::pair<std::string, long>> LoopRun::counters() const {
  return closer_ ? closer_->counters() : std::vector<std::pair<std::string, long>>();
}

std::vector<std::string> LoopRun::warnings() const {
  std::vector<std::string> out;
  if (!found()) out.push_back(notFound());
  if (!not_saved_.empty()) out.push_back(not_saved_);
  return out;
}

}  // namespace vir::estimator
