#include <algorithm>
#include <cmath>

#include "window_state.h"

namespace vir::window {
namespace {
/// A link between two standing frames longer than this is not extended: both are the same place, so
/// the standing keyframe simply moves on in time.
constexpr double kMaxRestLinkS = 1.0;

/// Time between keyframes while only the IMU and ranges say something [s].
constexpr double kBlindKeyframeS = 0.25;

struct SharedTracks {
  int shared = 0;          ///< tracks of the newest frame seen in the reference too
  int total = 0;           ///< tracks of the newest frame
  double parallax_px = 0;  ///< mean displacement with the rotation taken out
};

SharedTracks sharedWith(const WindowState& w, const Frame& reference) {
  const Frame& newest = *w.frames.back();
  std::vector<Quat> turns;  // of each camera
  for (int k = 0; k < w.cameras(); ++k) {
    const Quat q_W_C0 = reference.T_W_B().q * w.T_B_C(k).q;
    const Quat q_W_C1 = newest.T_W_B().q * w.T_B_C(k).q;
    turns.push_back(q_W_C0.conjugate() * q_W_C1);
  }
  SharedTracks out;
  double sum = 0;
  for (const auto& [id, l] : w.landmarks) {
    if (l.sights.back().frame != &newest) continue;
    ++out.total;
    // What the same camera has seen of it.
    const LandmarkSight& now = l.sights.back();
    for (const LandmarkSight& s : l.sights) {
      if (s.frame != &reference || s.camera != now.camera) continue;
      ++out.shared;
      const Quat& q_C0_C1 = turns[static_cast<std::size_t>(s.camera)];
      sum += (q_C0_C1 * now.sight.bearing - s.sight.bearing).norm();
      break;
    }
  }
  if (out.shared) out.parallax_px = sum / out.shared * w.focalPx();
  return out;
}

/// The camera's clock against the IMU's: two quartzes differ by tens of parts per million.
void letClockWander(const WindowState& w, double dt_s, NormalEquations* prior) {
  for (int k = 0; k < w.cameras(); ++k) {
    const int camera = prior->offsetOf(k == 0 ? w.camera_parameters : w.beside(k).parameters);
    if (camera < 0) continue;
    const double sigma = w.options.time_offset_walk;
    addProcessNoise(camera + factors::kTimeOffset, sigma * sigma * dt_s, prior);
  }
}

}  // namespace

bool decideKeyframe(const WindowState& w) {
  if (w.frames.size() < 2) return true;
  const Frame& newest = *w.frames.back();
  const Frame& last = *w.frames[w.frames.size() - 2];
  if (newest.standing) return !last.standing;
  if (last.standing) return true;
  const SharedTracks s = sharedWith(w, last);
  // Blind, but with ranges: they need states to act on.
  if (s.total == 0) return w.ranging() && toSeconds(newest.t - last.t) > kBlindKeyframeS;
  if (s.shared < w.options.keyframe_min_shared * s.total) return true;
  if (s.parallax_px > w.options.keyframe_parallax_px) return true;
  return toSeconds(newest.t - last.t) > w.options.keyframe_max_interval_s &&
         s.parallax_px > 0.3 * w.options.keyframe_parallax_px;
}

bool endsRestLink(const WindowState& w) {
  if (w.frames.size() < 2) return false;
  const Frame& n = *w.frames.back();
  return n.standing && w.frames[w.frames.size() - 2]->standing && n.link->dt() > kMaxRestLinkS;
}

void dropNewestInto(WindowState& w, imu::Preintegration* link) {
  Frame& n = w.newest();
  Frame& before = *w.frames[w.frames.size() - 2];
  removeSightsOf(w, &n);
  moveRanges(&n, &before);
  if (endsRestLink(w)) {
    before.t = n.t;
  } else {
    imu::Preintegration merged = std::move(*n.link);
    merged.append(*link);
    *link = std::move(merged);
  }
  w.frames.pop_back();
}

void marginalizeOldest(WindowState& w) {
  Frame& oldest = *w.frames.front();
  const Frame* newest = w.frames.back().get();
  if (w.long_window && !w.long_window->empty()) handToLongWindow(w);
  // Landmarks that ended go into the prior whole. Those still followed lose only this frame's sight
  // and move to their next one: their later sights would otherwise count twice.
  std::vector<std::uint64_t> into_prior;
  for (auto& [id, l] : w.landmarks) {
    if (l.host() != &oldest) continue;
    const bool alive = l.sights.back().frame == newest;
    if (l.has_depth && l.sights.size() >= 2 && !alive) into_prior.push_back(id);
  }
  TermSet set(w);
  set.addOldest(into_prior);

  std::vector<BlockRef> order = frameBlocks(w, 0, w.frames.size());
  addCalibrationBlocks(w, &order);
  // Blocks no term touches (speeds of later frames) are left out.
  std::vector<BlockRef> touched;
  for (std::size_t k = 0; k < order.size(); ++k) {
    bool used = k < 2;
    for (const Term& t : set.terms()) {
      if (used) break;
      used = std::find(t.blocks.begin(), t.blocks.end(), order[k].data) != t.blocks.end();
    }
    if (used) touched.push_back(order[k]);
  }
  const NormalEquations full = eliminateLandmarks(set.terms(), touched);
  NormalEquations rest = marginalizeFirst(full, 2);
  letClockWander(w, toSeconds(w.frames[1]->t - oldest.t), &rest);
  w.prior = toPrior(rest);
  w.prior_blocks.clear();
  for (const BlockRef& b : rest.blocks) w.prior_blocks.push_back(b.data);
  for (auto& f : w.frames) {
    if (std::find(w.prior_blocks.begin(), w.prior_blocks.end(), f->pose) != w.prior_blocks.end() &&
        f.get() != &oldest) {
      f->fixFirstEstimate();
    }
  }

  for (auto it = w.landmarks.begin(); it != w.landmarks.end();) {
    const WindowLandmark& l = it->second;
    const bool ended = l.host() == &oldest && l.sights.back().frame != newest;
    if (ended && l.has_depth) w.retired_landmarks.push_back({it->first, landmarkInWorld(w, l)});
    it = ended ? w.landmarks.erase(it) : std::next(it);
  }
  removeSightsOf(w, &oldest);
  w.frames.pop_front();
  w.frames.front()->link.reset();
}

}  // namespace vir::window
