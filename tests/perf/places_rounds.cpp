/// Recall, time and memory of the index of places in a robot that flies its round again and again:
/// places_rounds MAP KEYFRAMES... with a map file of `run --save-map`.
/// Every round sees the map's keyframes again, each bit of a descriptor flipped with 6 %, 20 cm
/// aside, every eighth corner another one. Looked for is one more round.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "vir/core/random.h"
#include "vir/mission/mission_map.h"
#include "vir/places/place_index.h"

using namespace vir;

namespace {

constexpr double kFlipped = 0.06, kReplaced = 0.125, kAside_m = 0.2;

double cpu() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

using Keyframe = std::shared_ptr<const PlaceKeyframe>;

/// A keyframe of a round as another round sees it.
std::shared_ptr<PlaceKeyframe> seenAgain(const PlaceKeyframe& k, std::uint64_t id, TimeNs t,
                                         Random* random) {
  auto out = std::make_shared<PlaceKeyframe>(k);
  out->id = id;
  out->t = t;
  out->segment = 0;
  out->T_W_B.p += kAside_m * Vec3(random->normal(), random->normal(), random->normal());
  for (PlacePoint& p : out->points) {
    const double share = random->uniform(0, 1) < kReplaced ? 0.5 : kFlipped;
    for (std::uint8_t& byte : p.descriptor) {
      for (int bit = 0; bit < 8; ++bit) {
        if (random->uniform(0, 1) < share) byte = static_cast<std::uint8_t>(byte ^ (1U << bit));
      }
    }
  }
  return out;
}

void measure(const std::vector<Keyframe>& round, std::size_t wanted, int max_keyframes) {
  Random random(1);
  places::PlaceIndexOptions o;
  o.max_keyframes = max_keyframes;
  places::PlaceIndex index(o);
  const TimeNs lasts = round.back()->t - round.front()->t + fromSeconds(10);
  double add_s = 0, slowest_s = 0;
  for (std::size_t id = 0; id < wanted; ++id) {
    const PlaceKeyframe& k = *round[id % round.size()];
    const TimeNs t = k.t + static_cast<TimeNs>(id / round.size()) * lasts;
    const Keyframe again = seenAgain(k, id, t, &random);
    const double begin = cpu();
    index.add(again);
    add_s += cpu() - begin;
    slowest_s = std::max(slowest_s, cpu() - begin);
  }
  const std::size_t queries = std::min<std::size_t>(round.size(), 200);
  std::size_t right = 0;
  double query_s = 0, worst_s = 0;
  for (std::size_t q = 0; q < queries; ++q) {
    const std::size_t at = q * round.size() / queries;
    const Keyframe again =
        seenAgain(*round[at], wanted + q, round.back()->t + fromSeconds(1e6), &random);
    const double begin = cpu();
    const auto found = index.query(*again, wanted);
    query_s += cpu() - begin;
    worst_s = std::max(worst_s, cpu() - begin);
    right += std::any_of(found.begin(), found.end(), [&](const places::PlaceCandidate& c) {
      const std::size_t off = (c.id % round.size() + round.size() - at) % round.size();
      return off <= 2 || off + 2 >= round.size();
    });
  }
  const double n = static_cast<double>(wanted),
               minutes = toSeconds(lasts) / 60 * n / static_cast<double>(round.size());
  const double bytes = static_cast<double>(index.bytes());
  std::printf(
      "%zu keyframes, %zu kept: found %.0f %%, query %.2f ms (slowest %.2f), add %.3f ms (slowest "
      "%.1f), %.1f MB: %.1f kB each, %.2f MB per minute\n",
      wanted, index.size(), 100.0 * static_cast<double>(right) / static_cast<double>(queries),
      1e3 * query_s / static_cast<double>(queries), 1e3 * worst_s, 1e3 * add_s / n, 1e3 * slowest_s,
      bytes / 1e6, bytes / 1e3 / static_cast<double>(index.size()), bytes / 1e6 / minutes);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const std::vector<Keyframe> round = mission::loadMap(argv[1]).keyframes;
  if (round.size() < 10) return 2;
  for (int a = 2; a < argc; ++a) {
    const int wanted = std::atoi(argv[a]);
    measure(round, static_cast<std::size_t>(wanted), 1000000);
    measure(round, static_cast<std::size_t>(wanted), std::max(100, wanted / 2));
  }
  return 0;
}
