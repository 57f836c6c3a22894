#include "vir/simulation/track_simulator.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "track_world.h"
#include "vir/core/angles.h"
#include "vir/core/order_statistics.h"
#include "vir/core/random.h"
#include "vir/simulation/interval.h"

namespace vir::simulation {
namespace {

/// Tracks do not survive a longer time without an image.
constexpr double kMaxGap_s = 0.5;
/// Two tracks nearer than this share of min_distance_px: the younger is given up, as the tracker
/// does.
constexpr double kCrowded = 0.4;
/// Motion of the image from which the noise is that of a moving camera [px].
constexpr double kMoving_px = 1.0;
/// Nothing is found nearer to the image's edge.
constexpr double kRim_px = 8;
constexpr double kIntensity = 110;
/// Share of the tracks that a wall without texture leaves.
constexpr double kBlindShare = 0.05;

Vec2 normal2(Random* random) {
  const double x = random->normal(), y = random->normal();
  return {x, y};
}

struct Track {
  std::size_t point = 0;
  double loss = 0;            // probability per image
  Vec2 clean = Vec2::Zero();  // pixel of the point itself, when last in sight
  bool in_sight = true;
  Vec2 offset = Vec2::Zero();
  bool outlier = false;
  int slides_from = 0;  // age
  Vec2 slide = Vec2::Zero();
  vision::FeatureObservation seen;
};

/// Where the camera is, ready for many points.
struct View {
  explicit View(const Pose& T_C_W) : T(T_C_W), R(T_C_W.R()) {}
  Vec3 operator*(const Vec3& p_W) const { return R * p_W + T.p; }
  Vec3 eye() const { return -(R.transpose() * T.p); }
  Pose T;
  Mat3 R;
};

}  // namespace

struct TrackSimulator::Impl {
  Impl(const TrackSimulationOptions& o, std::shared_ptr<const Motion> m,
       std::shared_ptr<const camera::CameraModel> c, const Pose& extrinsics,
       std::shared_ptr<const rendering::Scene> place)
      : options(o),
        motion(std::move(m)),
        camera(std::move(c)),
        T_B_C(extrinsics),
        scene(std::move(place)),
        slopes(widestSlopes()),
        world(o, *motion, scene.get()),
        births(static_cast<std::uint64_t>(o.seed), 410),
        noise(static_cast<std::uint64_t>(o.seed), 411),
        losses(static_cast<std::uint64_t>(o.seed), 412) {}

  /// Pixel of a point of the world; false when it is not in the image.
  Vec2 widestSlopes() const;
  bool see(std::size_t point, const View& view, Vec2* px) const;
  /// The same from where the camera is at the time of the row in which the point shows: `px` comes
  /// as seen from the place of the middle row.
  bool seeInItsRow(std::size_t point, TimeNs t, Vec2* px) const;
  /// Does something stand before it?
  bool hidden(std::size_t point, const View& view) const;
  bool mayShow(const TrackWorld::Block& block, const View& view) const;
  bool observe(const Vec2& px, vision::FeatureObservation* out) const;
  /// Projects the points of all tracks; returns the median motion of the image [px].
  double lookAgain(TimeNs t, const View& view);
  void follow(TimeNs t, const View& view, double survival_power, vision::TrackedFrame* frame);
  void giveUpCrowded(vision::TrackedFrame* frame);
  void start(TimeNs t, const View& view, double wanted_share, vision::TrackedFrame* frame);
  std::vector<std::pair<std::size_t, Vec2>> candidates(const View& view) const;
  Track born(std::size_t point);

  TrackSimulationOptions options;
  std::shared_ptr<const Motion> motion;
  std::shared_ptr<const camera::CameraModel> camera;
  Pose T_B_C;
  std::shared_ptr<const rendering::Scene> scene;  // may be null
  Vec2 slopes;
  TrackWorld world;
  Random births, noise, losses;
  std::vector<Track> tracks;  // by id
  std::map<std::uint64_t, std::size_t> point_of;
  std::uint64_t next_id = 1;
  std::uint64_t images = 0;
  bool any = false;
  TimeNs last_t = 0, last_usable = 0;
  Pose last_T_C_W;
};

/// Slopes x/z and y/z within which a point can show in the image.
Vec2 TrackSimulator::Impl::widestSlopes() const {
  const CameraCalibration& c = camera->calibration();
  Vec2 widest(0.1, 0.1);
  for (int k = 0; k <= 8; ++k) {
    const double s = k / 8.0;
    for (const Vec2& px : {Vec2(s * c.width, 0), Vec2(s * c.width, c.height), Vec2(0, s * c.height),
                           Vec2(c.width, s * c.height)}) {
      Vec3 b;
      if (!camera->unproject(px, &b)) continue;
      const double z = std::max(b.z(), 0.2);
      widest = widest.cwiseMax(Vec2(std::abs(b.x()), std::abs(b.y())) / z);
    }
  }
  return widest;
}

bool TrackSimulator::Impl::see(std::size_t point, const View& view, Vec2* px) const {
  const Vec3 p_C = view * world.points()[point];
  const double reach = options.max_distance_m;
  if (p_C.z() < options.min_depth_m || p_C.squaredNorm() > reach * reach) return false;
  // Far outside the image a distortion model may fold back into it.
  if (std::abs(p_C.x()) > slopes.x() * p_C.z() || std::abs(p_C.y()) > slopes.y() * p_C.z()) {
    return false;
  }
  if (!camera->project(p_C, px)) return false;
  const CameraCalibration& c = camera->calibration();
  return px->x() > kRim_px && px->y() > kRim_px && px->x() < c.width - kRim_px &&
         px->y() < c.height - kRim_px;
}

bool TrackSimulator::Impl::seeInItsRow(std::size_t point, TimeNs t, Vec2* px) const {
  if (options.readout_s <= 0) return true;
  // The row moves by far less than the image in one more look.
  for (int k = 0; k < 2; ++k) {
    const double row = px->y() / camera->calibration().height - 0.5;
    const TimeNs at =
        std::clamp(t + fromSeconds(row * options.readout_s), motion->begin(), motion->end());
    if (!see(point, View((motion->poseAt(at) * T_B_C).inverse()), px)) return false;
  }
  return true;
}

bool TrackSimulator::Impl::hidden(std::size_t point, const View& view) const {
  return scene && scene->hidden(view.eye(), world.points()[point]);
}

bool TrackSimulator::Impl::mayShow(const TrackWorld::Block& block, const View& view) const {
  const Vec3 c = view * block.centre;
  const double r = block.radius;
  return c.z() > -r && c.norm() - r < options.max_distance_m &&
         std::abs(c.x()) < slopes.x() * c.z() + r * std::sqrt(1 + slopes.x() * slopes.x()) &&
         std::abs(c.y()) < slopes.y() * c.z() + r * std::sqrt(1 + slopes.y() * slopes.y());
}

bool TrackSimulator::Impl::observe(const Vec2& px, vision::FeatureObservation* out) const {
  Vec2 again;
  if (!camera->unproject(px, &out->bearing)) return false;
  if (!camera->project(out->bearing, &again, &out->dpx_dbearing)) return false;
  out->px = px;
  return true;
}

Track TrackSimulator::Impl::born(std::size_t point) {
  Track k;
  k.point = point;
  const bool weak = births.uniform() < options.weak_share;
  k.loss = 1 / std::max(1.0, weak ? options.weak_track_images : options.mean_track_images);
  k.offset = options.offset_px * normal2(&births);
  k.outlier = births.uniform() < options.outlier_share;
  k.slides_from = static_cast<int>(10 * births.uniform());
  const double angle = births.uniform(0, 2 * kPi);
  k.slide = options.outlier_px * births.uniform(0.3, 1.7) * Vec2(std::cos(angle), std::sin(angle));
  k.seen.id = next_id;
  return k;
}

double TrackSimulator::Impl::lookAgain(TimeNs t, const View& view) {
  std::vector<double> flow;
  for (Track& k : tracks) {
    const Vec2 before = k.clean;
    k.in_sight =
        see(k.point, view, &k.clean) && !hidden(k.point, view) && seeInItsRow(k.point, t, &k.clean);
    if (k.in_sight) flow.push_back((k.clean - before).norm());
  }
  return median(flow);
}

void TrackSimulator::Impl::follow(TimeNs t, const View& view, double survival_power,
                                  vision::TrackedFrame* frame) {
  const double dt = toSeconds(t - last_usable);
  const double motion_px = lookAgain(t, view);
  const double white =
      options.noise_px *
      (options.rest_noise + (1 - options.rest_noise) * std::min(1.0, motion_px / kMoving_px));
  const Mat3 R_C0_C1 = (last_T_C_W * view.T.inverse()).R();
  std::vector<double> flow, parallax;
  std::vector<Track> kept;
  for (Track& k : tracks) {
    const double chance = losses.uniform();
    const Vec2 white_noise = normal2(&noise), step = normal2(&noise);
    k.offset += options.drift_px * std::min(1.0, motion_px / kMoving_px) * step;
    vision::FeatureObservation now = k.seen;
    ++now.age;
    if (chance > std::pow(1 - k.loss, survival_power) || !k.in_sight) {
      ++frame->lost_flow;
      continue;
    }
    if (k.outlier && now.age > k.slides_from) k.offset += k.slide;
    const Vec2 px = k.clean + k.offset + white * white_noise;
    const CameraCalibration& c = camera->calibration();
    const bool inside = px.x() > 1 && px.y() > 1 && px.x() < c.width - 2 && px.y() < c.height - 2;
    if (!inside || !observe(px, &now)) {
      ++frame->lost_flow;
      continue;
    }
    if (dt > 0) now.bearing_rate = (now.bearing - k.seen.bearing) / dt;
    flow.push_back((now.px - k.seen.px).norm());
    parallax.push_back(
        (now.dpx_dbearing * (now.bearing - R_C0_C1.transpose() * k.seen.bearing)).norm());
    k.seen = now;
    kept.push_back(k);
  }
  tracks = std::move(kept);
  frame->continued = static_cast<int>(tracks.size());
  frame->median_flow_px = median(flow);
  frame->median_parallax_px = median(parallax);
}

void TrackSimulator::Impl::giveUpCrowded(vision::TrackedFrame* frame) {
  const double limit = std::pow(kCrowded * options.min_distance_px, 2);
  std::vector<Track> kept;
  for (const Track& k : tracks) {
    const bool crowded = std::any_of(kept.begin(), kept.end(), [&](const Track& o) {
      return (o.seen.px - k.seen.px).squaredNorm() < limit;
    });
    if (crowded) {
      ++frame->lost_crowded;
    } else {
      kept.push_back(k);
    }
  }
  tracks = std::move(kept);
}

std::vector<std::pair<std::size_t, Vec2>> TrackSimulator::Impl::candidates(const View& view) const {
  // At most one per cell of the image, drawn among those that fall into it.
  struct Best {
    std::uint64_t score = 0;
    std::size_t point = 0;
    Vec2 px = Vec2::Zero();
  };
  const CameraCalibration& c = camera->calibration();
  const double cell = options.min_distance_px;
  const auto columns = static_cast<std::size_t>(c.width / cell) + 1;
  std::vector<Best> cells(columns * (static_cast<std::size_t>(c.height / cell) + 1));
  const std::uint64_t salt = mixBits(images + (static_cast<std::uint64_t>(options.seed) << 32));
  for (const TrackWorld::Block& b : world.blocks()) {
    if (!mayShow(b, view)) continue;
    for (std::size_t k = b.begin; k < b.end; ++k) {
      Vec2 px;
      if (!see(k, view, &px)) continue;
      const std::uint64_t score = mixBits(salt + k);
      Best& best = cells[static_cast<std::size_t>(px.y() / cell) * columns +
                         static_cast<std::size_t>(px.x() / cell)];
      if (score > best.score && !hidden(k, view)) best = {score, k, px};
    }
  }
  std::sort(cells.begin(), cells.end(), [](const Best& a, const Best& b) {
    return a.score != b.score ? a.score > b.score : a.point < b.point;
  });
  std::vector<std::pair<std::size_t, Vec2>> out;
  for (const Best& b : cells) {
    if (b.score > 0) out.emplace_back(b.point, b.px);
  }
  return out;
}

void TrackSimulator::Impl::start(TimeNs t, const View& view, double wanted_share,
                                 vision::TrackedFrame* frame) {
  const auto wanted = static_cast<std::size_t>(wanted_share * options.max_tracks);
  if (tracks.size() >= wanted) return;
  const double limit = options.min_distance_px * options.min_distance_px;
  for (const auto& [point, px] : candidates(view)) {
    if (tracks.size() >= wanted) break;
    const Vec2& at = px;
    if (std::any_of(tracks.begin(), tracks.end(),
                    [&](const Track& o) { return (o.seen.px - at).squaredNorm() < limit; })) {
      continue;
    }
    Track k = born(point);
    k.clean = px;
    if (!seeInItsRow(point, t, &k.clean) || !observe(k.clean + k.offset, &k.seen)) continue;
    point_of[next_id++] = point;
    tracks.push_back(k);
    ++frame->detected;
  }
}

TrackSimulator::TrackSimulator(const TrackSimulationOptions& options,
                               std::shared_ptr<const Motion> motion,
                               std::shared_ptr<const camera::CameraModel> camera, const Pose& T_B_C,
                               std::shared_ptr<const rendering::Scene> scene) {
  if (!motion || !camera) throw std::invalid_argument("TrackSimulator: no motion or no camera");
  if (!(options.rate_hz > 0) || !(options.min_distance_px > 0)) {
    throw std::invalid_argument("TrackSimulator: rate_hz and min_distance_px must be positive");
  }
  insideAny(options.blackout_s, 0);  // throws now rather than at the first image
  insideAny(options.blind_s, 0);
  impl_ = std::make_unique<Impl>(options, std::move(motion), std::move(camera), T_B_C,
                                 std::move(scene));
}
TrackSimulator::~TrackSimulator() = default;

std::vector<TimeNs> TrackSimulator::times() const {
  const Impl& s = *impl_;
  std::vector<TimeNs> out;
  for (int k = 0;; ++k) {
    const TimeNs t = s.motion->begin() + fromSeconds(s.options.phase_s + k / s.options.rate_hz);
    if (t > s.motion->end()) return out;
    out.push_back(t);
  }
}

vision::TrackedFrame TrackSimulator::at(TimeNs t) {
  Impl& s = *impl_;
  if (s.any && t <= s.last_t) throw std::invalid_argument("TrackSimulator: times must ascend");
  s.last_t = t;
  ++s.images;
  vision::TrackedFrame frame;
  frame.t = t;
  const double since_begin = toSeconds(t - s.motion->begin());
  if (insideAny(s.options.blackout_s, since_begin)) {
    frame.usable = false;
    frame.reason = "image is blank (mean grey level 0)";
    return frame;
  }
  frame.mean_intensity = kIntensity;
  const View view((s.motion->poseAt(t) * s.T_B_C).inverse());
  const bool blind = insideAny(s.options.blind_s, since_begin);
  if (s.any && !s.tracks.empty()) {
    const double gap = toSeconds(t - s.last_usable);
    if (gap > kMaxGap_s) {
      frame.lost_flow = static_cast<int>(s.tracks.size());
      s.tracks.clear();
    } else {
      s.follow(t, view, blind ? 1e9 : std::max(1.0, gap * s.options.rate_hz), &frame);
      s.giveUpCrowded(&frame);
    }
  }
  s.start(t, view, blind ? kBlindShare : 1.0, &frame);
  for (const Track& k : s.tracks) frame.features.push_back(k.seen);
  s.any = true;
  s.last_usable = t;
  s.last_T_C_W = view.T;
  return frame;
}

void TrackSimulator::stopFollowing(const std::vector<std::uint64_t>& ids) {
  const std::set<std::uint64_t> gone(ids.begin(), ids.end());
  std::vector<Track> kept;
  for (const Track& k : impl_->tracks) {
    if (!gone.count(k.seen.id)) kept.push_back(k);
  }
  impl_->tracks = std::move(kept);
}

bool TrackSimulator::pointOf(std::uint64_t id, Vec3* p_W) const {
  const auto it = impl_->point_of.find(id);
  if (it == impl_->point_of.end()) return false;
  *p_W = impl_->world.points()[it->second];
  return true;
}

std::size_t TrackSimulator::points() const { return impl_->world.points().size(); }

}  // namespace vir::simulation
