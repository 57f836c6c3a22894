#include "vir/vision/rig_tracker.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <future>
#include <map>
#include <stdexcept>
#include <utility>

#include "epipolar_search.h"
#include "tracker_impl.h"
#include "vir/core/order_statistics.h"
#include "vir/geometry/so3.h"

namespace vir::vision {
namespace {

/// Cameras see the same if this share of an image is in the other's.
constexpr double kOverlap = 0.15;
/// Of what one camera may have: the first of cameras that overlap (with less than all, two cameras
/// were worse than one on MH01 and the rendered eight), and the share of it that another one looks
/// for beside what was matched into it.
constexpr double kFirstShare = 1, kOwnShare = 0.05;
/// Of a sight that began as a match: what that was off by stays with it from image to image.
constexpr double kMatchedNoise = 2;
/// A match is tried when a track begins, and then after so many images, doubled every time. (Fewer
/// tries, or none before a track has lasted for two images, save 0.1 ms and cost accuracy.)
constexpr long kTryAgain = 6, kMostTries = 3;
/// Half the band that is searched, before anything is known and at least, and in medians of what
/// was found [px].
constexpr double kFirstBandPx = 10, kLeastBandPx = 2, kMedians = 4;
/// What is looked for first is at most so many times nearer than nine of ten matches of late.
constexpr double kNearer = 1.8;
/// Two cameras see a thing less alike than one does from image to image, and what is searched in
/// whole pixels begins farther off.
constexpr double kLooksAlike = 0.75;
constexpr int kAlignIterations = 20;
constexpr std::size_t kFewMatches = 20, kManyMatches = 200;

}  // namespace

struct RigTracker::Impl {
  struct Tries {
    long next = 0;
    long done = 0;
  };
  struct Pair {
    int a = 0, b = 0;
    std::map<std::uint64_t, Tries> tries;  ///< of tracks of `a` that `b` does not see
  };

  TrackerOptions options;
  std::vector<Camera> cameras;
  std::vector<std::unique_ptr<FeatureTracker>> trackers;
  std::vector<Pair> pairs;
  std::vector<bool> overlaps;    ///< by both cameras
  std::deque<double> beside;     ///< curves, of the latest matches and pairs [px]
  std::deque<double> inverse_m;  ///< distances of the latest matches [1/m]
  double most_inverse_m = 0;     ///< where matches are looked for first; 0: not known yet
  double band_px = kFirstBandPx;
  long round = 0;  ///< of process()

  FeatureTracker::Impl& tracker(int k) { return *trackers[static_cast<std::size_t>(k)]->impl_; }
  Pose between(int a, int b) const {
    return cameras[static_cast<std::size_t>(b)].T_B_C.inverse() *
           cameras[static_cast<std::size_t>(a)].T_B_C;
  }
  std::size_t at(int a, int b) const {
    return static_cast<std::size_t>(a) * cameras.size() + static_cast<std::size_t>(b);
  }

  TrackedFrame process(TimeNs t, const std::vector<RigImage>& images, const Vec3* rate,
                       std::vector<RigOutcome>* outcomes);
  std::vector<TrackedFrame> followAll(const std::vector<RigImage>& images, const Vec3* rate);
  void refuseFrozen(const std::vector<RigImage>& images, std::vector<TrackedFrame>* frames);
  void share(const std::vector<RigImage>& images, const std::vector<TrackedFrame>& frames);
  void match(Pair* pair);
  void checkPairs(int a, int b, bool same_time);
  void noteBeside(double px);
  void carry(const RigImage& image, TimeNs t, TrackedFrame* frame) const;
};

RigTracker::RigTracker(const TrackerOptions& options, const std::vector<Camera>& cameras)
    : impl_(std::make_unique<Impl>()) {
  if (cameras.empty()) throw std::invalid_argument("RigTracker: no camera given");
  impl_->options = options;
  impl_->cameras = cameras;
  const int n = static_cast<int>(cameras.size());
  for (int k = 0; k < n; ++k) {
    impl_->trackers.push_back(
        std::make_unique<FeatureTracker>(options, cameras[static_cast<std::size_t>(k)].model, k));
  }
  impl_->overlaps.assign(cameras.size() * cameras.size(), false);
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < n; ++b) {
      if (a == b) continue;
      const double share =
          overlapOf(*cameras[static_cast<std::size_t>(a)].model,
                    *cameras[static_cast<std::size_t>(b)].model, impl_->between(a, b));
      impl_->overlaps[impl_->at(a, b)] = share > kOverlap;
      if (share > kOverlap) impl_->pairs.push_back({a, b, {}});
    }
  }
}

RigTracker::~RigTracker() = default;

bool RigTracker::overlap(int a, int b) const { return impl_->overlaps.at(impl_->at(a, b)); }

double RigTracker::epipolarPx() const {
  std::vector<double> off(impl_->beside.begin(), impl_->beside.end());
  return off.size() < kFewMatches ? 0 : medianInPlace(&off);
}

void RigTracker::setExtrinsics(const std::vector<Pose>& T_B_C) {
  for (std::size_t k = 0; k < std::min(T_B_C.size(), impl_->cameras.size()); ++k) {
    impl_->cameras[k].T_B_C = T_B_C[k];
  }
}

void RigTracker::stopFollowing(const std::vector<std::uint64_t>& ids) {
  for (auto& tracker : impl_->trackers) tracker->stopFollowing(ids);
}

void RigTracker::reset() {
  for (auto& tracker : impl_->trackers) tracker->reset();
}

void RigTracker::reset(int camera) {
  impl_->trackers.at(static_cast<std::size_t>(camera))->reset();
}

TrackedFrame RigTracker::process(TimeNs t, const std::vector<RigImage>& images,
                                 std::vector<RigOutcome>* outcomes) {
  return impl_->process(t, images, nullptr, outcomes);
}

TrackedFrame RigTracker::processTurning(TimeNs t, const std::vector<RigImage>& images,
                                        const Vec3& rate, std::vector<RigOutcome>* outcomes) {
  return impl_->process(t, images, &rate, outcomes);
}

/// Each camera's tracks into its new image: side by side, they have nothing in common.
std::vector<TrackedFrame> RigTracker::Impl::followAll(const std::vector<RigImage>& images,
                                                      const Vec3* rate) {
  const auto follow = [this, rate](const RigImage& image) {
    FeatureTracker::Impl& own = tracker(image.camera);
    if (rate == nullptr) {
      return own.followInto(image.t, image.gray, image.R_C0_C1, kRotationRateSigma);
    }
    const double dt = own.last_t == 0 ? 0 : toSeconds(image.t - own.last_t);
    const Quat q = cameras[static_cast<std::size_t>(image.camera)].T_B_C.q.conjugate() *
                   cameras.front().T_B_C.q;
    return own.followInto(image.t, image.gray, expSO3(q * *rate * dt), kSteadyRateSigma);
  };
  std::vector<std::future<TrackedFrame>> others;
  for (std::size_t k = 1; k < images.size(); ++k) {
    others.push_back(std::async(std::launch::async, follow, std::cref(images[k])));
  }
  std::vector<TrackedFrame> out{follow(images.front())};
  for (auto& other : others) out.push_back(other.get());
  return out;
}

/// A camera that hangs gives one image again and again, to the last bit, while others see things
/// change.
void RigTracker::Impl::refuseFrozen(const std::vector<RigImage>& images,
                                    std::vector<TrackedFrame>* frames) {
  std::vector<bool> same(images.size());
  bool any_changed = false;
  for (std::size_t k = 0; k < images.size(); ++k) {
    const FeatureTracker::Impl& own = tracker(images[k].camera);
    if (!(*frames)[k].usable || own.last.empty()) continue;
    const cv::Mat &now = own.current.full(), &before = own.last.full();
    same[k] = now.size() == before.size() && std::memcmp(now.data, before.data, now.total()) == 0;
    any_changed = any_changed || !same[k];
  }
  for (std::size_t k = 0; k < images.size() && any_changed; ++k) {
    if (!same[k]) continue;
    (*frames)[k] = TrackedFrame();
    (*frames)[k].t = images[k].t;
    (*frames)[k].usable = false;
    (*frames)[k].reason = "image is the one before once more (the camera hangs)";
  }
}

/// Who sees nothing leaves its share to the others; what is matched counts in both.
void RigTracker::Impl::share(const std::vector<RigImage>& images,
                             const std::vector<TrackedFrame>& frames) {
  int usable = 0, alone = 0;
  for (std::size_t k = 0; k < images.size(); ++k) {
    if (!frames[k].usable) continue;
    ++usable;
    bool first = true;  // of those that see the same
    for (std::size_t j = 0; j < k; ++j) {
      if (frames[j].usable && overlaps[at(images[j].camera, images[k].camera)]) first = false;
    }
    alone += first;
  }
  for (std::size_t k = 0; k < images.size(); ++k) {
    if (!frames[k].usable) continue;
    FeatureTracker::Impl& own = tracker(images[k].camera);
    const double part = usable == alone ? 1.0 : kFirstShare;
    own.budget = static_cast<int>(std::lround(part * options.max_tracks / std::max(1, alone)));
  }
}

void RigTracker::Impl::noteBeside(double px) {
  beside.push_back(std::abs(px));
  if (beside.size() > kManyMatches) beside.pop_front();
}

/// What both follow must stay where it can be one point.
void RigTracker::Impl::checkPairs(int a, int b, bool same_time) {
  if (!same_time) return;
  const FeatureTracker::Impl& first = tracker(a);
  FeatureTracker::Impl& second = tracker(b);
  const Pose T_b_a = between(a, b);
  std::vector<std::uint64_t> wrong;
  std::size_t j = 0;
  for (const Track& track : second.tracks) {
    while (j < first.tracks.size() && first.tracks[j].seen.id < track.seen.id) ++j;
    if (j == first.tracks.size()) break;
    if (first.tracks[j].seen.id != track.seen.id) continue;
    const double off = besideCurvePx(T_b_a, first.tracks[j].seen.bearing, track.seen.bearing,
                                     track.seen.dpx_dbearing);
    noteBeside(off);
    if (std::abs(off) > band_px + 1) wrong.push_back(track.seen.id);
  }
  trackers[static_cast<std::size_t>(b)]->stopFollowing(wrong);
}

void RigTracker::Impl::match(Pair* pair) {
  const FeatureTracker::Impl& first = tracker(pair->a);
  FeatureTracker::Impl& second = tracker(pair->b);
  const Pose T_b_a = between(pair->a, pair->b);
  const EpipolarView from{first.camera.get(), &first.current};
  const EpipolarView to{second.camera.get(), &second.current};
  EpipolarOptions search{band_px, 0, options.patch_px, kAlignIterations,
                         kLooksAlike * options.min_similarity};
  std::map<std::uint64_t, Tries> tries;
  for (const Track& track : first.tracks) {
    const std::uint64_t id = track.seen.id;
    const auto seen =
        std::lower_bound(second.tracks.begin(), second.tracks.end(), id,
                         [](const Track& t, std::uint64_t x) { return t.seen.id < x; });
    if (seen != second.tracks.end() && seen->seen.id == id) continue;
    const auto before = pair->tries.find(id);
    Tries now = before == pair->tries.end() ? Tries() : before->second;
    if (round >= now.next && now.done < kMostTries) {
      // Once more: it may be nearer than what was found of late.
      search.most_inverse_m = now.done == 0 ? most_inverse_m : 0;
      const auto px = matchAlongCurve(from, track.seen.px, to, T_b_a, search);
      if (px && second.adopt(id, *px)) {
        const Track& found =
            *std::lower_bound(second.tracks.begin(), second.tracks.end(), id,
                              [](const Track& t, std::uint64_t x) { return t.seen.id < x; });
        noteBeside(
            besideCurvePx(T_b_a, track.seen.bearing, found.seen.bearing, found.seen.dpx_dbearing));
        inverse_m.push_back(inverseDistance(T_b_a, track.seen.bearing, found.seen.bearing));
        if (inverse_m.size() > kManyMatches) inverse_m.pop_front();
        continue;
      }
      now.next = round + (kTryAgain << now.done);
      ++now.done;
    }
    tries[id] = now;
  }
  pair->tries = std::move(tries);
}

/// As seen at `t`.
void RigTracker::Impl::carry(const RigImage& image, TimeNs t, TrackedFrame* frame) const {
  const double dt = toSeconds(t - image.t);
  if (dt == 0) return;
  // What turns past is known by the gyro, how near it is only once it was followed.
  const TimeNs since = trackers[static_cast<std::size_t>(image.camera)]->impl_->before_last_t;
  const double span = since == 0 ? 0 : toSeconds(image.t - since);
  const Vec3 turn = span > 0 ? Vec3(logSO3(image.R_C0_C1) / span) : Vec3(Vec3::Zero());
  constexpr double kRateNoise = 1.4, kUnknownNoise = 3;
  for (FeatureObservation& f : frame->features) {
    const bool followed = f.age > 0;
    const Vec3 rate = followed ? f.bearing_rate : Vec3(-turn.cross(f.bearing));
    f.px += dt * f.dpx_dbearing * rate;
    f.bearing = (f.bearing + dt * rate).normalized();
    const double part = span > 0 ? std::abs(dt) / span : 1;
    f.noise = std::hypot(1.0, part * (followed ? kRateNoise : kUnknownNoise));
  }
}

TrackedFrame RigTracker::Impl::process(TimeNs t, const std::vector<RigImage>& images,
                                       const Vec3* rate, std::vector<RigOutcome>* outcomes) {
  ++round;
  std::vector<TrackedFrame> frames = followAll(images, rate);
  if (cameras.size() > 1) {
    refuseFrozen(images, &frames);
    share(images, frames);
  }
  std::vector<std::size_t> usable;
  for (std::size_t k = 0; k < images.size(); ++k) {
    if (outcomes != nullptr) {
      outcomes->push_back({images[k].camera, frames[k].usable, frames[k].reason});
    }
    if (!frames[k].usable) continue;
    FeatureTracker::Impl& own = tracker(images[k].camera);
    own.watch = StageLaps();
    const int allowed = own.budget;
    bool overlapped = false;
    for (const std::size_t j : usable) {
      const int a = images[j].camera, b = images[k].camera;
      if (!overlaps[at(a, b)]) continue;
      overlapped = true;
      checkPairs(a, b, images[j].t == images[k].t);
      for (Pair& pair : pairs) {
        if (pair.a == a && pair.b == b) match(&pair);
      }
    }
    if (overlapped) {
      // Corners of its own beside what was matched into it.
      const int matched = static_cast<int>(
          std::count_if(own.tracks.begin(), own.tracks.end(), [&own](const Track& track) {
            return (track.seen.id >> kIdBits) != static_cast<std::uint64_t>(own.number);
          }));
      own.budget = std::min(allowed, matched + static_cast<int>(kOwnShare * options.max_tracks));
    }
    own.detect(&frames[k]);
    for (const std::size_t j : usable) {
      for (Pair& pair : pairs) {
        if (pair.a == images[k].camera && pair.b == images[j].camera) match(&pair);
      }
    }
    usable.push_back(k);
  }
  if (beside.size() >= kFewMatches) {
    std::vector<double> off(beside.begin(), beside.end());
    std::vector<double> inverse(inverse_m.begin(), inverse_m.end());
    const auto at_share = static_cast<std::size_t>(0.9 * static_cast<double>(inverse.size()));
    if (inverse.size() >= kFewMatches) {
      std::nth_element(inverse.begin(), inverse.begin() + static_cast<std::ptrdiff_t>(at_share),
                       inverse.end());
      most_inverse_m = kNearer * inverse[at_share];
    }
    band_px = std::clamp(kMedians * medianInPlace(&off), kLeastBandPx, kFirstBandPx);
  }
  for (const std::size_t k : usable) {
    FeatureTracker::Impl& own = tracker(images[k].camera);
    own.before_last_t = own.last_t;
    own.conclude(&frames[k]);
    carry(images[k], t, &frames[k]);
    for (FeatureObservation& f : frames[k].features) {
      if ((f.id >> kIdBits) != static_cast<std::uint64_t>(f.camera)) f.noise *= kMatchedNoise;
    }
  }
  // The first camera's, or, without it, none of its features and the rest.
  TrackedFrame out;
  const bool first = images.front().camera == 0;
  if (first) {
    out = std::move(frames.front());
  } else {
    out.usable = false;
    out.reason = frames.front().reason;
  }
  out.t = t;
  for (std::size_t k = first ? 1 : 0; k < images.size(); ++k) {
    const TrackedFrame& other = frames[k];
    if (!other.usable) continue;
    if (!out.usable) out.usable = true;
    out.reason.clear();
    out.further.insert(out.further.end(), other.features.begin(), other.features.end());
    out.ms_pyramid += other.ms_pyramid;
    out.ms_flow += other.ms_flow;
    out.ms_detect += other.ms_detect;
  }
  std::stable_sort(out.further.begin(), out.further.end(),
                   [](const FeatureObservation& x, const FeatureObservation& y) {
                     return x.id != y.id ? x.id < y.id : x.camera < y.camera;
                   });
  return out;
}

}  // namespace vir::vision
