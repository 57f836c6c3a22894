#include "image_sets.h"

#include <gtest/gtest.h>

namespace vir::estimator {
namespace {

constexpr TimeNs kMs = 1000000;

struct Sorted {
  explicit Sorted(TimeNs offset_ms = 0) : left_out(2) {
    sets.addCamera(0);
    sets.addCamera(offset_ms * kMs);
  }
  bool add(int camera, TimeNs t_ms) {
    WaitingImage image;
    image.t = (1000 + t_ms) * kMs;
    image.camera = camera;
    return sets.add(std::move(image));
  }
  /// Whose images the next set has: "0", "1", "01", or "" if none is complete; `t_ms` its time.
  std::string next(bool all = false) {
    const auto set = sets.next(all, &left_out);
    std::string out;
    if (!set) return out;
    t_ms = set->t / kMs - 1000;
    for (const WaitingImage& i : set->images) out += std::to_string(i.camera);
    return out;
  }
  ImageSets sets;
  std::vector<long> left_out;
  TimeNs t_ms = 0;
};

TEST(ImageSets, OneOfEachIsASet) {
  Sorted s;
  EXPECT_TRUE(s.add(0, 0));
  EXPECT_EQ(s.next(), "");  // the other one may come
  EXPECT_TRUE(s.add(1, 0));
  EXPECT_EQ(s.next(), "01");
  EXPECT_TRUE(s.add(1, 50));
  EXPECT_EQ(s.next(), "");
  EXPECT_TRUE(s.add(0, 50));
  EXPECT_EQ(s.next(), "01");
  EXPECT_FALSE(s.add(0, 50));
  EXPECT_FALSE(s.add(1, 20));
}

TEST(ImageSets, ClocksAreApartAndNearestCounts) {
  Sorted s(7);
  for (const TimeNs t : {0, 50, 100}) {
    s.add(0, t);
    s.add(1, t);  // 7 ms later
    EXPECT_EQ(s.next(), "01");
    EXPECT_EQ(s.t_ms, t);
  }
}

TEST(ImageSets, ClocksMayBeFurtherApartThanImages) {
  for (const TimeNs apart : {120, -120}) {
    Sorted s(apart);
    int both = 0;
    for (TimeNs t = 0; t <= 1500; t += 50) {
      s.add(0, t);
      s.add(1, t);  // the others' time by `apart` later
      for (std::string now = s.next(); !now.empty(); now = s.next()) both += now == "01";
    }
    EXPECT_GE(both, 24) << apart;
  }
}

TEST(ImageSets, WithoutPartnerByTheTimeOfTheRecording) {
  Sorted s;
  for (const TimeNs t : {0, 50}) {
    s.add(0, t);
    s.add(1, t);
    EXPECT_EQ(s.next(), "01");
  }
  s.add(0, 100);
  EXPECT_EQ(s.next(), "");
  s.add(0, 150);
  EXPECT_EQ(s.next(), "0");
  EXPECT_EQ(s.t_ms, 100);
  s.add(1, 150);
  EXPECT_EQ(s.next(), "01");
  // Gone for more than a second: not waited for any more.
  for (TimeNs t = 200; t <= 1300; t += 50) {
    s.add(0, t);
    while (!s.next().empty()) {
    }
  }
  EXPECT_EQ(s.t_ms, 1300);
}

TEST(ImageSets, TheOthersGoOnWithoutTheFirst) {
  Sorted s;
  for (const TimeNs t : {0, 50}) {
    s.add(0, t);
    s.add(1, t);
    EXPECT_EQ(s.next(), "01");
  }
  int alone = 0;
  for (TimeNs t = 100; t <= 500; t += 50) {
    s.add(1, t);
    while (s.next() == "1") ++alone;
  }
  EXPECT_GE(alone, 6);
  s.add(0, 550);
  s.add(1, 550);
  std::string last;
  for (std::string now = s.next(); !now.empty(); now = s.next()) last = now;
  EXPECT_EQ(last, "01");
  EXPECT_EQ(s.t_ms, 550);
}

TEST(ImageSets, FasterThanTheFirstIsLeftOutAndCounted) {
  Sorted s;
  int both = 0;
  for (TimeNs t = 0; t <= 1000; t += 25) {
    if (t % 100 == 0) s.add(0, t);
    s.add(1, t);
    for (std::string now = s.next(); !now.empty(); now = s.next()) both += now == "01";
  }
  EXPECT_GE(both, 10);
  EXPECT_GE(s.left_out[1], 20);
}

TEST(ImageSets, EverythingComesOutAtTheEnd) {
  Sorted s;
  s.add(0, 0);
  EXPECT_EQ(s.next(), "");
  EXPECT_EQ(s.next(true), "0");
  EXPECT_EQ(s.next(true), "");
}

}  // namespace
}  // namespace vir::estimator
