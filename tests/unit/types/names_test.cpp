/// Words in files that others read: each stands for one thing, and comes back as it.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "vir/types/anchor.h"
#include "vir/types/range.h"
#include "vir/types/state.h"

namespace vir {
namespace {

TEST(Names, StatesOfAnchorsComeBack) {
  for (int i = 0; i <= static_cast<int>(AnchorState::moved); ++i) {
    const auto state = static_cast<AnchorState>(i);
    AnchorState back = state == AnchorState::fixed ? AnchorState::moved : AnchorState::fixed;
    EXPECT_TRUE(parse(name(state), &back)) << name(state);
    EXPECT_EQ(back, state) << name(state);
  }
  AnchorState untouched = AnchorState::estimated;
  for (const char* word : {"", "Fixed", "fixed ", "accepted"}) {
    EXPECT_FALSE(parse(word, &untouched)) << word;
  }
  EXPECT_EQ(untouched, AnchorState::estimated);
}

TEST(Names, EveryDecisionHasAWordOfItsOwn) {
  const int n = static_cast<int>(RangeDecision::before_the_start) + 1;
  std::set<std::string> words;
  for (int i = 0; i < n; ++i) words.insert(name(static_cast<RangeDecision>(i)));
  EXPECT_EQ(words.size(), static_cast<std::size_t>(n));
  EXPECT_EQ(words.count("accepted") + words.count("too_long") + words.count("before_the_start"),
            3u);
}

TEST(Names, AHealthGivesItsReasonBehindItsWord) {
  StateEstimate estimate;
  estimate.health = Health::doubtful;
  EXPECT_EQ(healthText(estimate), "doubtful");
  estimate.reason = "few tracks";
  EXPECT_EQ(healthText(estimate), "doubtful: few tracks");
}

}  // namespace
}  // namespace vir
