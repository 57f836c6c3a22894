#include "vir/mission/loop_closer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "graph_edges.h"
#include "map_anchors.h"
#include "place_graph.h"
#include "vir/camera/camera_model.h"

namespace vir::mission {
namespace {

constexpr double kPauseS = 3;
constexpr double kWorthTelling = 1e-3;  // [m]
/// Rows of loops.csv that are kept of what was not accepted; the others are counted.
constexpr std::size_t kMostRefusals = 20000;
constexpr std::size_t kMostLandmarks = 200000;
/// Rays that have moved by more than this are made anew, of so many keyframes at a time: others
/// wait.
constexpr double kRaysMoved_px = 0.1;
constexpr std::size_t kRaysAtOnce = 50;

}  // namespace

struct LoopCloser::Impl {
  Impl(const LoopOptions& o, const Calibration& c, LogSink l)
      : options(o),
        calibration(c),
        log_sink(std::move(l)),
        camera(camera::makeCamera(c.camera)),
        describer(o.describer, camera),
        places(o),
        pace(o) {}

  /// Was there a loop just before? The next metres would say the same again; but a run that has
  /// just been found in a map hardly knows where it is.
  bool pauses(const PlaceKeyframe& k) const {
    const bool settled = !has_map || !pace.within(KeyframePace::kSearch_s);
    return was_found && settled && last_loop && toSeconds(k.t - last_loop->t) < kPauseS &&
           (k.T_W_B.p - last_loop->T_W_B.p).norm() < options.pause_m;
  }
  void note(const std::vector<places::LoopAttempt>& attempts);
  /// The calibration as the estimator has it by now: keyframes of the run see with it as well.
  void calibrate(const Calibration& estimated);
  /// How the estimator's covariance at the newest keyframe becomes that of the graph.
  void learn(const StateEstimate& estimate);
  void refuse(const Loop& loop, const std::string& why);
  LoopRecord recordOf(const Loop& loop) const;

  LoopOptions options;
  Calibration calibration;
  LogSink log_sink;
  std::shared_ptr<const camera::CameraModel> camera;  ///< as it is known by now
  places::Describer describer;
  PlaceGraph places;
  KeyframePace pace;
  MissionMap loaded;     ///< its keyframes are in `places`, as far as they are remembered
  bool has_map = false;  ///< with a place in it
  std::uint64_t next_id = 1, first_own = 1;
  int segments_before = 0;  ///< of the map
  std::optional<StampedPose> last_loop;
  std::map<TimeNs, std::uint64_t> ids;            ///< of the run's keyframes
  std::vector<std::weak_ptr<PlaceKeyframe>> own;  ///< the run's, as far as they are remembered
  /// While ranges hold the path its newest pose stays where they have it; only the past is bent.
  std::optional<LevelTransform> frozen;
  std::optional<Eigen::Matrix4d> known;  ///< see learn()
  std::optional<StateEstimate> newest;   ///< of the keyframes
  std::size_t rays_done = 0;             ///< of `own`: the first so many have rays of `camera`
  std::vector<LoopRecord> refusals;
  std::vector<StampedPose> told;  ///< as of the last revision
  std::optional<Revision> revision;
  long keyframes = 0, attempts = 0, refused = 0, solutions = 0;
  bool was_found = true;
  bool new_loop = false;  ///< since the last solution
};

LoopCloser::LoopCloser(const LoopOptions& options, const Calibration& calibration, LogSink log) {
  options.validate();
  impl_ = std::make_unique<Impl>(options, calibration, std::move(log));
}
LoopCloser::~LoopCloser() = default;

void LoopCloser::begin(const MissionMap& map) {
  Impl& m = *impl_;
  if (m.keyframes > 0) throw std::logic_error("LoopCloser: a map comes before all keyframes");
  const std::string other = cameraDifference(map.calibration.camera, m.calibration.camera);
  if (!other.empty()) throw std::invalid_argument("the map is of another camera: " + other);
  m.loaded.calibration = map.calibration;
  m.loaded.anchors = map.anchors;
  m.has_map = !map.keyframes.empty();
  for (const auto& k : map.keyframes) {
    m.segments_before = std::max(m.segments_before, k->segment + 1);
    m.places.remember(*k);
    m.next_id = k->id + 1;
  }
  m.first_own = m.next_id;
  m.was_found = !m.has_map;
}

void LoopCloser::setAnchors(const std::vector<Anchor>& in_W) {
  Impl& m = *impl_;
  if (m.was_found) return;
  m.places.setAnchors(m.loaded.anchors, in_W);
}

void LoopCloser::add(const SeenKeyframe& seen) {
  Impl& m = *impl_;
  if (!m.pace.wants(seen.estimate, m.was_found)) return;
  if (!seen.turn_held || m.has_map) {
    m.frozen.reset();
  } else if (!m.frozen) {
    m.frozen = m.places.graph().correction();
  }
  const State& s = seen.estimate.state;
  auto k = std::make_shared<PlaceKeyframe>();
  k->id = m.next_id;
  k->t = s.t;
  k->segment = seen.estimate.segment;
  k->T_W_B = s.T_W_B;
  if (seen.estimate.calibration.camera.width > 0) m.calibrate(seen.estimate.calibration);
  k->T_B_C = m.calibration.T_B_C;
  k->points = m.describer.points(seen.gray, (k->T_W_B * k->T_B_C).q, seen.landmarks);
  const auto compare = [&](const std::vector<places::ExpectedPoint>& expected) {
    return m.describer.compare(seen.gray, (k->T_W_B * k->T_B_C).q, expected);
  };
  try {
    const bool look = !m.pauses(*k);
    const PathNode node{k->id,
                        k->t,
                        k->segment,
                        k->T_W_B,
                        seen.estimate.covariance,
                        seen.segment_since,
                        seen.held,
                        seen.held && !seen.turn_held};
    const long loops = m.places.add(k, node, look, compare);
    if (loops > 0) {
      m.last_loop = StampedPose{k->t, k->T_W_B};
      m.new_loop = true;
    }
  } catch (const std::invalid_argument& e) {
    log(m.log_sink, LogLevel::debug, std::string("no place: ") + e.what());
    return;
  }
  if (m.rays_done == m.own.size()) ++m.rays_done;
  m.own.push_back(k);
  ++m.next_id;
  ++m.keyframes;
  m.ids[k->t] = k->id;
  m.pace.took(seen.estimate);
  m.newest = seen.estimate;
  m.learn(*m.newest);
  m.note(m.places.attempts());
  for (const Loop& loop : m.places.againstAnchors()) m.refuse(loop, "against anchors");
  if (m.was_found || !m.places.graph().joined()) return;
  m.was_found = true;
  m.places.setAnchors({}, {});
  log(m.log_sink, LogLevel::info, "the run was found in the map");
}

void LoopCloser::Impl::calibrate(const Calibration& estimated) {
  calibration.T_B_C = estimated.T_B_C;
  auto now = camera::makeCamera(estimated.camera);
  if (places::raysMoved(*camera, *now) > kRaysMoved_px) {
    calibration.camera = estimated.camera;
    camera = std::move(now);
    describer.setCamera(camera);
    rays_done = 0;
  }
  for (std::size_t n = 0; n < kRaysAtOnce && rays_done < own.size(); ++n, ++rays_done) {
    const auto k = own[rays_done].lock();
    if (!k) continue;
    places::setRays(*camera, &k->points);
    k->T_B_C = calibration.T_B_C;
  }
}

void LoopCloser::Impl::note(const std::vector<places::LoopAttempt>& looked) {
  attempts += static_cast<long>(looked.size());
  for (const places::LoopAttempt& a : looked) {
    const auto& found = a.verdict.found;
    // Accepted ones and those that wait are the graph's. A place is seen from several keyframes, of
    // which the best one is taken: the others are no refusals.
    if (!found || a.decision == "accepted" || a.decision == "waits for another" ||
        a.decision == "second to another") {
      continue;
    }
    refuse(*found, a.decision);
  }
}

void LoopCloser::Impl::refuse(const Loop& loop, const std::string& why) {
  ++refused;
  if (refusals.size() >= kMostRefusals) return;
  LoopRecord r = recordOf(loop);
  r.decision = why;
  refusals.push_back(r);
}

LoopRecord LoopCloser::Impl::recordOf(const Loop& loop) const {
  LoopRecord r;
  r.in_map = loop.older < first_own;
  r.matches = loop.matches;
  r.inliers = loop.inliers;
  r.T_older_newer = loop.T_older_newer;
  if (const auto k = places.finder().index().find(loop.older)) r.t_older = k->t;
  if (const auto k = places.finder().index().find(loop.newer)) r.t_newer = k->t;
  if (const auto T = places.graph().poseOf(loop.older)) r.p_older = T->p;
  if (const auto T = places.graph().poseOf(loop.newer)) r.p_newer = T->p;
  return r;
}

bool LoopCloser::solveDue() const {
  const Impl& m = *impl_;
  // The first loops of a run in a map are of images before the first pose: later ones know better.
  const bool arriving = m.new_loop && m.has_map && m.pace.within(KeyframePace::kSearch_s);
  return arriving || m.places.graph().solveDue();
}

void LoopCloser::solve(const std::vector<FollowedPose>& keyframes, bool last) {
  Impl& m = *impl_;
  Odometry odometry;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const FollowedPose& k = keyframes[i];
    if (i > 0) {
      const FollowedPose& before = keyframes[i - 1];
      const bool told = before.to_next.minCoeff() > 0;
      odometry.T_O_B.p +=
          before.scale * (told ? before.motion_O : Vec3(k.T_O_B.p - before.T_O_B.p));
      odometry.variance += before.to_next;
    }
    odometry.T_O_B.q = k.T_O_B.q;
    const auto id = m.ids.find(k.t);
    if (id != m.ids.end()) m.places.graph().move(id->second, k.T_W_B, odometry);
  }
  if (last) m.places.graph().takeOdometry();
  m.places.graph().solve();
  m.new_loop = false;
  ++m.solutions;
  if (m.newest) m.learn(*m.newest);
  const std::vector<StampedPose> path = m.places.graph().path();
  Revision out;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const bool known = i < m.told.size();
    if (known && (path[i].T_W_B.p - m.told[i].T_W_B.p).norm() < kWorthTelling) continue;
    out.keyframes.push_back(path[i]);
  }
  m.told = path;
  if (path.empty() || out.keyframes.empty()) return;
  out.t = path.back().t;
  m.revision = std::move(out);
}

LevelTransform LoopCloser::correction() const {
  return impl_->frozen ? *impl_->frozen : impl_->places.graph().correction();
}
LevelTransform LoopCloser::correctionAt(TimeNs t) const {
  return impl_->places.graph().correctionAt(t);
}

void LoopCloser::Impl::learn(const StateEstimate& e) {
  known.reset();
  const auto now = places.graph().covariance();
  if (!now || frozen) return;
  const Mat3 R = rotZ(places.graph().correction().yaw_rad);
  Eigen::Matrix4d before = levelCovariance(e.covariance, e.state.T_W_B.R());
  before.topRows<3>() = R * before.topRows<3>();
  before.leftCols<3>() = before.leftCols<3>() * R.transpose();
  // What the estimator knows better by itself, as by anchors, is not the path's to say.
  const double better = now->topLeftCorner<3, 3>().trace() / before.topLeftCorner<3, 3>().trace();
  if (before.diagonal().minCoeff() > 0 && better < 1) known = transportOf(before, *now);
}

Correction LoopCloser::now() const { return {correction(), impl_->known}; }

std::optional<Revision> LoopCloser::takeRevision() {
  return std::exchange(impl_->revision, std::nullopt);
}

bool LoopCloser::acts() const { return impl_->places.graph().counts().accepted > 0; }
bool LoopCloser::found() const { return impl_->was_found; }

std::vector<LoopRecord> LoopCloser::records() const {
  const Impl& m = *impl_;
  std::vector<LoopRecord> out = m.refusals;
  for (const JudgedLoop& l : m.places.graph().loops()) {
    LoopRecord r = m.recordOf(l.loop);
    if (l.t_newer != 0) {
      r.t_older = l.t_older;
      r.t_newer = l.t_newer;
    }
    r.chi2 = l.chi2;
    r.accepted = l.state == LoopState::accepted;
    r.decision = name(l.state);
    out.push_back(r);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const LoopRecord& a, const LoopRecord& b) { return a.t_newer < b.t_newer; });
  return out;
}

long LoopCloser::rejected() const {
  const LoopCounts c = impl_->places.graph().counts();
  return impl_->refused + c.refused + c.taken_back + c.waiting;
}

std::vector<std::pair<std::string, long>> LoopCloser::counters() const {
  const Impl& m = *impl_;
  const LoopCounts c = m.places.graph().counts();
  return {{"places", m.keyframes},          {"loop_candidates", m.attempts},
          {"loops_accepted", c.accepted},   {"loops_waiting", c.waiting},
          {"loops_refused", c.refused},     {"loops_taken_back", c.taken_back},
          {"loops_implausible", m.refused}, {"loop_solutions", m.solutions}};
}

std::vector<Landmark> LoopCloser::landmarks() const {
  const Impl& m = *impl_;
  std::vector<Landmark> out;
  for (const auto& k : m.places.finder().index().keyframes()) {
    if (k->id < m.first_own) continue;
    const auto T_M_B = m.places.graph().poseOf(k->id);
    if (!T_M_B) continue;
    addMapPoints(*k, *T_M_B, m.options.max_landmark_sigma, &out);
  }
  if (out.size() <= kMostLandmarks) return out;
  const std::size_t step = out.size() / kMostLandmarks + 1;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < out.size(); i += step) out[kept++] = out[i];
  out.resize(kept);
  return out;
}

MissionMap LoopCloser::map(const Calibration& calibration,
                           const std::vector<Anchor>& anchors) const {
  const Impl& m = *impl_;
  MissionMap out;
  const bool extends = m.has_map && m.was_found;
  if (extends) out = m.loaded;
  out.calibration = calibration;
  for (const auto& k : m.places.finder().index().keyframes()) {
    const bool own = k->id >= m.first_own;
    if (!own && !extends) continue;
    const auto T_M_B = m.places.graph().poseOf(k->id);
    if (!T_M_B) continue;
    auto copy = std::make_shared<PlaceKeyframe>(*k);
    copy->T_W_B = *T_M_B;
    if (!own) {
      copy->segment = PlaceGraph::segmentInMap(*k);
    } else if (extends) {
      copy->segment += m.segments_before;
    }
    out.keyframes.push_back(std::move(copy));
  }
  out.anchors = joinAnchors(out.anchors, anchors, m.log_sink);
  return out;
}

}  // namespace vir::mission
