#include "image_sets.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace vir::estimator {
namespace {

constexpr TimeNs kFirstReach = 10000000;  // [ns] until times between images are known
/// A camera that has been silent for longer is not waited for [ns].
constexpr TimeNs kGone = 1000000000;
/// The first camera is missed after so many of its images, and at the beginning after as long [ns].
constexpr TimeNs kMissed = 2;
constexpr TimeNs kAtBegin = 500000000;
constexpr std::size_t kMostWaiting = 100;

}  // namespace

void ImageSets::addCamera(TimeNs offset) {
  cameras_.emplace_back();
  cameras_.back().offset = offset;
}

bool ImageSets::add(WaitingImage image) {
  Camera& c = cameras_[static_cast<std::size_t>(image.camera)];
  image.at = image.t + c.offset;
  if (c.last != 0 && image.at <= c.last) return false;
  if (c.last != 0) {
    const TimeNs now = image.at - c.last;
    c.period = c.period == 0 ? now : std::min(now, c.period + c.period / 8);
  }
  c.last = image.at;
  if (latest_ == 0) begin_ = image.at;
  latest_ = std::max(latest_, image.at);
  c.waiting.push_back(std::move(image));
  return true;
}

TimeNs ImageSets::reach() const {
  TimeNs least = 0;
  for (const Camera& c : cameras_) {
    if (c.period != 0 && (least == 0 || c.period < least)) least = c.period;
  }
  return least == 0 ? kFirstReach : least / 2;
}

TimeNs ImageSets::clocksApart() const {
  const auto [least, most] =
      std::minmax_element(cameras_.begin(), cameras_.end(),
                          [](const Camera& a, const Camera& b) { return a.offset < b.offset; });
  return most->offset - least->offset;
}

/// Is an image of the first camera to be expected about `t`?
bool ImageSets::firstGoesOn(TimeNs t) const {
  const Camera& first = cameras_.front();
  if (!first.waiting.empty()) return true;
  if (first.last == 0) return t - begin_ < kAtBegin;
  return t - first.last < kMissed * std::max(first.period, 2 * kFirstReach);
}

bool ImageSets::complete(TimeNs t) const {
  const TimeNs half = reach();
  // Images come by their own stamps: of clocks that are apart, one after the other.
  if (latest_ > t + half + clocksApart()) return true;
  for (const Camera& c : cameras_) {
    if (c.waiting.size() > kMostWaiting) return true;
    if (c.last >= t - half && (!c.waiting.empty() || c.last > t + half)) continue;
    const TimeNs silent_since = c.last == 0 ? begin_ : c.last;
    if (silent_since < t - kGone && &c != &cameras_.front()) continue;
    return false;
  }
  return true;
}

std::optional<ImageSet> ImageSets::next(bool all, std::vector<long>* left_out) {
  while (true) {
    const Camera* lead = nullptr;
    for (const Camera& c : cameras_) {
      if (c.waiting.empty()) continue;
      if (lead == nullptr || c.waiting.front().at < lead->waiting.front().at) lead = &c;
    }
    if (lead == nullptr) return std::nullopt;
    const TimeNs half = reach();
    Camera& first = cameras_.front();
    if (!first.waiting.empty() && first.waiting.front().at <= lead->waiting.front().at + half) {
      lead = &first;
    }
    const TimeNs t = lead->waiting.front().at;
    if (!all && !complete(t)) return std::nullopt;
    if (lead != &first && firstGoesOn(t)) {
      // Between images of the first camera: faster than that one, or its partner was nearer.
      const auto at = static_cast<std::size_t>(lead - cameras_.data());
      if (left_out != nullptr) ++left_out->at(at);
      cameras_[at].waiting.pop_front();
      continue;
    }
    ImageSet out;
    out.t = t;
    for (Camera& c : cameras_) {
      std::size_t best = c.waiting.size();
      for (std::size_t k = 0; k < c.waiting.size(); ++k) {
        const TimeNs off = std::abs(c.waiting[k].at - t);
        if (off <= half && (best == c.waiting.size() || off < std::abs(c.waiting[best].at - t))) {
          best = k;
        }
      }
      if (best == c.waiting.size()) continue;
      for (std::size_t k = 0; k < best; ++k) {
        if (left_out != nullptr) ++left_out->at(static_cast<std::size_t>(&c - cameras_.data()));
        c.waiting.pop_front();
      }
      out.images.push_back(std::move(c.waiting.front()));
      c.waiting.pop_front();
    }
    return out;
  }
}

void ImageSets::clear() {
  for (Camera& c : cameras_) {
    c.waiting.clear();
    c.last = c.period = 0;
  }
  latest_ = begin_ = 0;
}

}  // namespace vir::estimator
