/// Recall, time and memory of the index of places: places_index DESCRIPTORS KEYFRAMES...
/// DESCRIPTORS: a file of places_recording (32 bytes each, 200 per keyframe). Every seventh of its
/// keyframes is remembered among made-up ones and looked for with the one three later. Made-up
/// descriptors are put together of eighths of real ones.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <memory>
#include <vector>

#include "vir/core/random.h"
#include "vir/places/place_index.h"

using namespace vir;

namespace {

constexpr std::size_t kPerKeyframe = 200, kBytes = 32;
constexpr std::size_t kEvery = 7, kLater = 3;

double cpu() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  std::ifstream in(argv[1], std::ios::binary);
  const std::vector<char> pool((std::istreambuf_iterator<char>(in)), {});
  const std::size_t descriptors = pool.size() / kBytes, real = descriptors / kPerKeyframe;
  if (real < kEvery) return 2;
  const auto put = [&](std::size_t descriptor, std::size_t from, std::size_t bytes, PlacePoint* p) {
    std::memcpy(p->descriptor.data() + from, &pool[descriptor * kBytes + from], bytes);
  };
  const auto realKeyframe = [&](std::size_t k) {
    auto out = std::make_shared<PlaceKeyframe>();
    out->points.resize(kPerKeyframe);
    for (std::size_t i = 0; i < kPerKeyframe; ++i) {
      put(k * kPerKeyframe + i, 0, kBytes, &out->points[i]);
    }
    return out;
  };
  for (int a = 2; a < argc; ++a) {
    const auto wanted = static_cast<std::size_t>(std::atol(argv[a]));
    Random random(1);
    places::PlaceIndexOptions o;
    o.max_keyframes = 1000000;
    places::PlaceIndex index(o);
    std::vector<std::pair<std::size_t, std::uint64_t>> targets;  // real keyframe, id
    const std::size_t rounds = (real - kLater) / kEvery;
    double add_s = 0;
    for (std::size_t id = 0; id < wanted; ++id) {
      std::shared_ptr<PlaceKeyframe> k;
      const std::size_t spacing = wanted / rounds;
      if (id % spacing == 0 && targets.size() < rounds) {
        targets.emplace_back(targets.size() * kEvery, id);
        k = realKeyframe(targets.back().first);
      } else {
        k = std::make_shared<PlaceKeyframe>();
        k->points.resize(kPerKeyframe);
        for (PlacePoint& p : k->points) {
          for (std::size_t from = 0; from < kBytes; from += 4) {
            put(random.below(descriptors), from, 4, &p);
          }
        }
      }
      k->id = id;
      k->t = fromSeconds(10.0 * static_cast<double>(id));
      const double begin = cpu();
      index.add(k);
      add_s += cpu() - begin;
    }
    int first = 0, among = 0;
    const double begin = cpu();
    for (const auto& [k, id] : targets) {
      const auto found = index.query(*realKeyframe(k + kLater));
      first += !found.empty() && found.front().id == id;
      for (const auto& c : found) among += c.id == id;
    }
    const double n = static_cast<double>(targets.size());
    std::printf(
        "%zu keyframes: first %.0f %%, among %d candidates %.0f %%, query %.2f ms, add %.2f ms, "
        "%.1f MB (%.1f kB each)\n",
        wanted, 100 * first / n, o.candidates, 100 * among / n, 1000 * (cpu() - begin) / n,
        1000 * add_s / static_cast<double>(wanted), static_cast<double>(index.bytes()) / 1e6,
        static_cast<double>(index.bytes()) / 1e3 / static_cast<double>(wanted));
  }
  return 0;
}
