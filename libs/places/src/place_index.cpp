#include "vir/places/place_index.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include "place_thinning.h"
#include "vir/core/random.h"
#include "vir/core/time.h"
#include "vir/places/hamming.h"

namespace vir::places {
namespace {

constexpr int kTables = 4;
/// A table starts with few buckets and splits them, up to so many bits of a key, as it fills.
constexpr std::size_t kFirstKeyBits = 12, kKeyBits = 20;
constexpr std::size_t kFilled = 8;  // entries per bucket
/// What looks like so many others says little: a full bucket forgets its oldest.
constexpr std::size_t kBucketLimit = 512;
/// An entry is the number of the keyframe and that of the point.
constexpr int kPointBits = 10;
constexpr std::size_t kMaxPoints = (std::size_t{1} << kPointBits) - 1;
/// Thinning takes away one keyframe of so many at a time.
constexpr std::size_t kThinned = 20;
constexpr std::size_t kNotThinned = 100;  // the newest

struct Bucket {
  std::vector<std::uint32_t> entries;
  std::uint32_t next = 0;  // where the next one goes when it is full
};

/// The oldest first.
void inOrder(Bucket* b) {
  std::rotate(b->entries.begin(), b->entries.begin() + b->next, b->entries.end());
  b->next = 0;
}

struct Slot {
  std::shared_ptr<const PlaceKeyframe> keyframe;
  const PlacePoint* points = nullptr;
};

}  // namespace

struct PlaceIndex::Impl {
  explicit Impl(const PlaceIndexOptions& o) : options(o) {
    Random random(1, 610);
    for (auto& bits : key_bits) {
      // Different bits within a table; the tables may share some.
      std::array<int, 256> all;
      std::iota(all.begin(), all.end(), 0);
      for (std::size_t k = 0; k < kKeyBits; ++k) {
        std::swap(all[k], all[k + random.below(256 - k)]);
        bits[k] = all[k];
      }
    }
    for (auto& table : tables) table.resize(std::size_t{1} << used_bits);
  }

  std::size_t keyBit(int table, std::size_t k, const Descriptor& d) const {
    const int bit = key_bits[static_cast<std::size_t>(table)][k];
    return (d[static_cast<std::size_t>(bit / 8)] >> (bit % 8)) & 1U;
  }
  /// The bucket: by `used_bits` bits, or one more where it has been split.
  std::size_t key(int table, const Descriptor& d) const {
    std::size_t out = 0;
    for (std::size_t k = 0; k < used_bits; ++k) out |= keyBit(table, k, d) << k;
    return out < split ? out | keyBit(table, used_bits, d) << used_bits : out;
  }
  std::size_t buckets() const { return (std::size_t{1} << used_bits) + split; }
  std::size_t slotOf(std::uint64_t id) const {
    const auto at = std::lower_bound(
        slots.begin(), slots.end(), id,
        [](const Slot& s, std::uint64_t wanted) { return s.keyframe->id < wanted; });
    return static_cast<std::size_t>(at - slots.begin());
  }
  bool has(std::size_t slot, std::uint64_t id) const {
    return slot < slots.size() && slots[slot].keyframe->id == id;
  }
  void put(Bucket* bucket, std::uint32_t entry) const;
  void splitOne();
  void thin();
  std::vector<PlaceCandidate> score(const PlaceKeyframe& keyframe, std::size_t end) const;

  PlaceIndexOptions options;
  std::array<std::array<int, kKeyBits>, kTables> key_bits{};
  std::size_t used_bits = kFirstKeyBits, split = 0;
  std::size_t points = 0;
  std::array<std::vector<Bucket>, kTables> tables;
  std::vector<Slot> slots;  // by id
};

void PlaceIndex::Impl::put(Bucket* bucket, std::uint32_t entry) const {
  if (bucket->entries.size() < kBucketLimit) {
    bucket->entries.push_back(entry);
    return;
  }
  bucket->entries[bucket->next] = entry;
  bucket->next = (bucket->next + 1) % kBucketLimit;
}

/// The next bucket becomes two, by one more bit: a few with each keyframe, so that none has to wait
/// for all of them.
void PlaceIndex::Impl::splitOne() {
  for (int t = 0; t < kTables; ++t) {
    auto& table = tables[static_cast<std::size_t>(t)];
    Bucket low, high;
    inOrder(&table[split]);
    for (const std::uint32_t e : table[split].entries) {
      const Descriptor& d = slots[e >> kPointBits].points[e & kMaxPoints].descriptor;
      (keyBit(t, used_bits, d) ? high : low).entries.push_back(e);
    }
    table[split] = std::move(low);
    table.push_back(std::move(high));
  }
  if (++split < std::size_t{1} << used_bits) return;
  split = 0;
  ++used_bits;
}

void PlaceIndex::Impl::thin() {
  std::vector<const PlaceKeyframe*> all;
  for (const Slot& s : slots) all.push_back(s.keyframe.get());
  const std::size_t newest = std::min(kNotThinned, slots.size() / 2);
  const std::vector<bool> gone =
      redundantPlaces(all, std::max<std::size_t>(1, slots.size() / kThinned), newest);
  std::vector<std::uint32_t> moved(slots.size(), 0);
  std::vector<Slot> left;
  for (std::size_t k = 0; k < slots.size(); ++k) {
    moved[k] = static_cast<std::uint32_t>(left.size());
    if (!gone[k]) left.push_back(slots[k]);
  }
  slots.swap(left);
  points = 0;
  for (const Slot& s : slots) points += std::min(s.keyframe->points.size(), kMaxPoints);
  for (auto& table : tables) {
    for (Bucket& b : table) {
      inOrder(&b);
      std::size_t kept = 0;
      for (const std::uint32_t e : b.entries) {
        const std::uint32_t slot = e >> kPointBits;
        if (gone[slot]) continue;
        b.entries[kept++] = (moved[slot] << kPointBits) | (e & kMaxPoints);
      }
      b.entries.resize(kept);
    }
  }
}

std::vector<PlaceCandidate> PlaceIndex::Impl::score(const PlaceKeyframe& keyframe,
                                                    std::size_t end) const {
  constexpr int kNone = 1000;
  std::vector<double> scores(end, 0);
  std::vector<int> votes(end, 0), best(end, kNone);
  std::vector<std::uint32_t> hit;
  for (const PlacePoint& p : keyframe.points) {
    hit.clear();
    for (int t = 0; t < kTables; ++t) {
      for (const std::uint32_t e :
           tables[static_cast<std::size_t>(t)][key(t, p.descriptor)].entries) {
        const std::uint32_t slot = e >> kPointBits;
        if (slot >= end) continue;
        const int d = hammingDistance(p.descriptor, slots[slot].points[e & kMaxPoints].descriptor);
        if (d > options.max_distance_bits) continue;
        if (best[slot] == kNone) hit.push_back(slot);
        best[slot] = std::min(best[slot], d);
      }
    }
    if (hit.empty()) continue;
    std::sort(hit.begin(), hit.end());
    // Places, not keyframes: a descriptor that is seen in one place for long is rare all the same.
    int places = 1;
    for (std::size_t k = 1; k < hit.size(); ++k) {
      places +=
          toSeconds(slots[hit[k]].keyframe->t - slots[hit[k - 1]].keyframe->t) > options.group_s;
    }
    const double rare = 1 / (1 + std::log(places));
    for (const std::uint32_t slot : hit) {
      scores[slot] += rare * (1 - 0.5 * best[slot] / options.max_distance_bits);
      ++votes[slot];
      best[slot] = kNone;
    }
  }
  std::vector<PlaceCandidate> out;
  for (std::size_t k = 0; k < end; ++k) {
    if (votes[k] >= options.min_votes) out.push_back({slots[k].keyframe->id, scores[k], votes[k]});
  }
  std::sort(out.begin(), out.end(), [](const PlaceCandidate& a, const PlaceCandidate& b) {
    return a.score != b.score ? a.score > b.score : a.id < b.id;
  });
  return out;
}

PlaceIndex::PlaceIndex(const PlaceIndexOptions& options) {
  options.validate();
  impl_ = std::make_unique<Impl>(options);
}
PlaceIndex::~PlaceIndex() = default;
PlaceIndex::PlaceIndex(PlaceIndex&&) noexcept = default;
PlaceIndex& PlaceIndex::operator=(PlaceIndex&&) noexcept = default;

void PlaceIndex::add(std::shared_ptr<const PlaceKeyframe> keyframe) {
  if (!keyframe) throw std::invalid_argument("no keyframe to remember");
  if (!impl_->slots.empty() && keyframe->id <= impl_->slots.back().keyframe->id) {
    throw std::invalid_argument("keyframe " + std::to_string(keyframe->id) + " after keyframe " +
                                std::to_string(impl_->slots.back().keyframe->id) +
                                ": ids must rise");
  }
  if (impl_->slots.size() >= static_cast<std::size_t>(impl_->options.max_keyframes)) impl_->thin();
  const std::size_t slot = impl_->slots.size();
  const std::size_t points = std::min(keyframe->points.size(), kMaxPoints);
  for (std::size_t k = 0; k < points; ++k) {
    const auto entry = static_cast<std::uint32_t>((slot << kPointBits) | k);
    for (int t = 0; t < kTables; ++t) {
      auto& table = impl_->tables[static_cast<std::size_t>(t)];
      impl_->put(&table[impl_->key(t, keyframe->points[k].descriptor)], entry);
    }
  }
  const PlacePoint* const first = keyframe->points.data();
  impl_->slots.push_back({std::move(keyframe), first});
  impl_->points += points;
  while (impl_->used_bits < kKeyBits && impl_->points > kFilled * impl_->buckets()) {
    impl_->splitOne();
  }
}

std::vector<PlaceCandidate> PlaceIndex::query(const PlaceKeyframe& keyframe, std::uint64_t before,
                                              const Allowed& allowed) const {
  const std::size_t end = impl_->slotOf(before);
  std::vector<PlaceCandidate> out;
  std::vector<const PlaceKeyframe*> taken;
  for (const PlaceCandidate& c : impl_->score(keyframe, end)) {
    if (static_cast<int>(out.size()) >= impl_->options.candidates) break;
    const PlaceKeyframe* k = impl_->slots[impl_->slotOf(c.id)].keyframe.get();
    const bool near = std::any_of(taken.begin(), taken.end(), [&](const PlaceKeyframe* other) {
      return other->segment == k->segment &&
             std::abs(toSeconds(other->t - k->t)) <= impl_->options.group_s;
    });
    if (near || (allowed && !allowed(*k))) continue;
    taken.push_back(k);
    out.push_back(c);
  }
  return out;
}

std::shared_ptr<const PlaceKeyframe> PlaceIndex::find(std::uint64_t id) const {
  const std::size_t slot = impl_->slotOf(id);
  return impl_->has(slot, id) ? impl_->slots[slot].keyframe : nullptr;
}

std::vector<std::shared_ptr<const PlaceKeyframe>> PlaceIndex::around(std::uint64_t id,
                                                                     int reach) const {
  const std::size_t slot = impl_->slotOf(id);
  if (!impl_->has(slot, id)) return {};
  const auto& all = impl_->slots;
  std::vector<std::shared_ptr<const PlaceKeyframe>> out{all[slot].keyframe};
  const auto take = [&](std::size_t k) {
    const PlaceKeyframe& a = *all[slot].keyframe;
    const PlaceKeyframe& b = *all[k].keyframe;
    if (a.segment != b.segment || std::abs(toSeconds(a.t - b.t)) > impl_->options.group_s) return;
    out.push_back(all[k].keyframe);
  };
  for (std::size_t step = 1; step <= static_cast<std::size_t>(std::max(reach, 0)); ++step) {
    if (step <= slot) take(slot - step);
    if (slot + step < all.size()) take(slot + step);
  }
  return out;
}

std::vector<std::shared_ptr<const PlaceKeyframe>> PlaceIndex::keyframes() const {
  std::vector<std::shared_ptr<const PlaceKeyframe>> out;
  for (const Slot& s : impl_->slots) out.push_back(s.keyframe);
  return out;
}

std::size_t PlaceIndex::size() const { return impl_->slots.size(); }

std::size_t PlaceIndex::bytes() const {
  std::size_t sum = sizeof(Impl) + impl_->slots.capacity() * sizeof(Slot);
  for (const auto& table : impl_->tables) {
    sum += table.capacity() * sizeof(Bucket);
    for (const Bucket& b : table) sum += b.entries.capacity() * sizeof(std::uint32_t);
  }
  for (const Slot& s : impl_->slots) {
    sum += sizeof(PlaceKeyframe) + s.keyframe->points.capacity() * sizeof(PlacePoint);
  }
  return sum;
}

}  // namespace vir::places
