#include "vir/results/advice.h"

#include <gtest/gtest.h>

namespace vir::results {
namespace {

StateEstimate saying(Health health, const std::string& reason) {
  StateEstimate e;
  e.health = health;
  e.reason = reason;
  return e;
}

TEST(Advice, WhoStandsIsToldToMove) {
  for (const char* reason : {"standing still", "too little parallax"}) {
    EXPECT_NE(adviceFor(saying(Health::starting, reason)).find("move sideways"), std::string::npos);
  }
  EXPECT_NE(adviceFor(saying(Health::starting, "scale uncertain")).find("constant speed"),
            std::string::npos);
  EXPECT_NE(adviceFor(saying(Health::lost, "no landmarks, IMU only")).find("saw before"),
            std::string::npos);
  EXPECT_NE(adviceFor(saying(Health::starting, "image not usable: image is blank")).find("light"),
            std::string::npos);
}

TEST(Advice, NoneWhereAllIsWell) {
  EXPECT_EQ(adviceFor(saying(Health::ok, "")), "");
  EXPECT_EQ(adviceFor(saying(Health::standing, "standing still")), "");
  EXPECT_EQ(adviceFor(saying(Health::starting, "something new")), "");
}

TEST(Advice, TheFirstAnchorThatNeedsSomething) {
  EXPECT_EQ(adviceFor(std::vector<Anchor>{}), "no ranges yet");
  Anchor found, open;
  found.id = 1;
  open.id = 7;
  open.advice = "change height";
  EXPECT_EQ(adviceFor(std::vector<Anchor>{found}), "");
  EXPECT_EQ(adviceFor(std::vector<Anchor>{found, open}), "anchor 7: change height");
}

}  // namespace
}  // namespace vir::results
