/// The index finds what looks alike, forgets what is seen twice, and is the same every time.
#include "vir/places/place_index.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "made_places.h"

namespace {

using namespace vir;
using places::PlaceIndex;
using places::PlaceIndexOptions;
using vir_test::KeyframePtr;

/// A keyframe of `points` random descriptors, at a place of its own.
KeyframePtr randomPlace(std::uint64_t id, double s, Random* random, int points = 150) {
  auto k = std::make_shared<PlaceKeyframe>();
  k->id = id;
  k->t = fromSeconds(s);
  k->T_W_B.p = Vec3(2.0 * static_cast<double>(id), 0, 0);
  for (int i = 0; i < points; ++i) {
    PlacePoint p;
    p.descriptor = vir_test::randomDescriptor(random);
    k->points.push_back(p);
  }
  return k;
}

/// `share` of the points are seen again, with `flipped` of their bits turned.
PlaceKeyframe seenAgain(const PlaceKeyframe& k, double share, double flipped, Random* random) {
  PlaceKeyframe out = k;
  out.id = k.id + 1000000;
  for (PlacePoint& p : out.points) {
    p.descriptor = random->uniform() < share ? vir_test::disturbed(p.descriptor, flipped, random)
                                             : vir_test::randomDescriptor(random);
  }
  return out;
}

TEST(PlaceIndex, FindsAThirdOfThePointsAgain) {
  Random random(1);
  PlaceIndex index({});
  std::vector<KeyframePtr> all;
  for (std::uint64_t id = 0; id < 500; ++id) {
    all.push_back(randomPlace(id, 5.0 * static_cast<double>(id), &random));
    index.add(all.back());
  }
  int first = 0;
  for (std::size_t k = 0; k < all.size(); k += 5) {
    const auto found = index.query(seenAgain(*all[k], 0.35, 0.12, &random));
    first += !found.empty() && found.front().id == all[k]->id;
  }
  EXPECT_GE(first, 98);
  // A place never seen looks like none.
  for (int k = 0; k < 50; ++k) {
    EXPECT_TRUE(index.query(*randomPlace(9999, 0, &random)).empty());
  }
}

TEST(PlaceIndex, LooksOnlyBeforeTheIdGiven) {
  Random random(2);
  PlaceIndex index({});
  const KeyframePtr a = randomPlace(10, 0, &random);
  index.add(a);
  EXPECT_EQ(index.query(*a).size(), 1U);
  EXPECT_EQ(index.query(*a, 11).size(), 1U);
  EXPECT_TRUE(index.query(*a, 10).empty());
  EXPECT_TRUE(index.query(*a, 0).empty());
}

TEST(PlaceIndex, NeighboursAreOnePlace) {
  Random random(3);
  PlaceIndex index({});
  const KeyframePtr a = randomPlace(0, 0, &random);
  // The same place at 0, 1 and 2 s, and once more a minute later.
  const double times[] = {0, 1, 2, 60};
  for (std::uint64_t id = 0; id < 4; ++id) {
    auto k = std::make_shared<PlaceKeyframe>(*a);
    k->id = id;
    k->t = fromSeconds(times[id]);
    index.add(k);
  }
  const auto found = index.query(*a);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].id, 0U);
  EXPECT_EQ(found[1].id, 3U);
  const auto around = index.around(1, 2);
  ASSERT_EQ(around.size(), 3U);
  EXPECT_EQ(around[0]->id, 1U);
  EXPECT_EQ(around[1]->id, 0U);
  EXPECT_EQ(around[2]->id, 2U);
  EXPECT_TRUE(index.around(77, 2).empty());
  EXPECT_EQ(index.find(3)->id, 3U);
  EXPECT_EQ(index.find(4), nullptr);
}

TEST(PlaceIndex, ForgetsWhatIsSeenTwiceNotWhatIsOld) {
  Random random(4);
  PlaceIndexOptions o;
  o.max_keyframes = 400;
  PlaceIndex index(o);
  std::vector<KeyframePtr> once;
  std::uint64_t id = 0;
  // 100 places seen once, long ago; then 900 looks at one and the same place.
  for (; id < 100; ++id) {
    once.push_back(randomPlace(id, static_cast<double>(id), &random, 60));
    index.add(once.back());
  }
  for (; id < 1000; ++id) {
    const KeyframePtr k = randomPlace(id, static_cast<double>(id), &random, 60);
    k->T_W_B.p = Vec3(-5, 0, 0);
    index.add(k);
    ASSERT_LE(index.size(), 400U);
  }
  for (const KeyframePtr& k : once) {
    ASSERT_NE(index.find(k->id), nullptr) << k->id;
    const auto found = index.query(seenAgain(*k, 0.6, 0.1, &random));
    ASSERT_FALSE(found.empty()) << k->id;
    EXPECT_EQ(found.front().id, k->id);
  }
  for (std::uint64_t newest = 900; newest < 1000; ++newest) EXPECT_NE(index.find(newest), nullptr);
}

TEST(PlaceIndex, MemoryIsBoundedWhateverComes) {
  PlaceIndexOptions o;
  o.max_keyframes = 200;
  PlaceIndex index(o);
  // All alike, all at one place or nowhere, in segments of their own.
  std::size_t half_way = 0;
  for (std::uint64_t id = 0; id < 2000; ++id) {
    auto k = std::make_shared<PlaceKeyframe>();
    k->id = id;
    k->segment = static_cast<int>(id);
    k->T_W_B.p.x() = std::numeric_limits<double>::quiet_NaN();
    k->points.resize(100);
    index.add(k);
    if (id == 1000) half_way = index.bytes();
  }
  EXPECT_LE(index.size(), 200U);
  EXPECT_LE(index.bytes(), half_way + half_way / 20);
  PlaceKeyframe same;
  same.points.resize(100);
  EXPECT_LE(index.query(same).size(), 5U);
}

TEST(PlaceIndex, RefusesIdsThatDoNotRise) {
  Random random(5);
  PlaceIndex index({});
  index.add(randomPlace(5, 0, &random));
  EXPECT_THROW(index.add(randomPlace(5, 1, &random)), std::invalid_argument);
  EXPECT_THROW(index.add(randomPlace(4, 1, &random)), std::invalid_argument);
  EXPECT_THROW(index.add(nullptr), std::invalid_argument);
  EXPECT_EQ(index.size(), 1U);
  index.add(std::make_shared<PlaceKeyframe>([] {
    PlaceKeyframe k;
    k.id = 6;
    return k;
  }()));
  EXPECT_TRUE(index.query(PlaceKeyframe()).empty());
  EXPECT_EQ(index.keyframes().size(), 2U);
}

TEST(PlaceIndex, SameCallsSameAnswers) {
  const auto answers = [] {
    Random random(6);
    PlaceIndexOptions o;
    o.max_keyframes = 150;
    PlaceIndex index(o);
    std::vector<std::pair<std::uint64_t, double>> out;
    KeyframePtr last;
    for (std::uint64_t id = 0; id < 300; ++id) {
      const KeyframePtr k = randomPlace(id, static_cast<double>(id), &random, 50);
      index.add(k);
      if (last) {
        for (const auto& c : index.query(seenAgain(*last, 0.5, 0.1, &random))) {
          out.emplace_back(c.id, c.score);
        }
      }
      last = k;
    }
    return out;
  };
  const auto first = answers();
  EXPECT_GT(first.size(), 250U);
  EXPECT_EQ(first, answers());
}

}  // namespace
