#include "dialogue.h"

#include <gtest/gtest.h>

namespace vir::uwb {
namespace {

void hear(Dwm1001Dialogue* d, const std::string& text) {
  d->hear(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
}

TEST(Dialogue, StreamingDeviceIsLeftAlone) {
  Dwm1001Dialogue d;
  for (int i = 0; i < 100; ++i) EXPECT_EQ(d.step(0.1 * i, i), "");
  EXPECT_FALSE(d.engaged());
}

TEST(Dialogue, SilentDeviceIsWokenAndTold) {
  Dwm1001Dialogue d;
  EXPECT_EQ(d.step(0, 0), "");
  EXPECT_EQ(d.step(1.9, 0), "");
  EXPECT_EQ(d.step(2.0, 0), "\r\r");
  EXPECT_EQ(d.step(2.1, 0), "");
  hear(&d, "\r\n DWM1001 TWR Real Time Location System\r\n\r\ndw");
  EXPECT_EQ(d.step(2.2, 0), "");
  hear(&d, "m> ");
  EXPECT_EQ(d.step(2.3, 0), "lec\r");
  EXPECT_EQ(d.step(2.4, 0), "");
  EXPECT_EQ(d.step(2.5, 1), "");
  EXPECT_EQ(d.step(2.6, 2), "");
}

TEST(Dialogue, NoPromptNoCommand) {
  Dwm1001Dialogue d;
  int sent = 0;
  for (int i = 0; i < 1200; ++i) {
    const std::string words = d.step(0.1 * i, 0);
    EXPECT_TRUE(words.empty() || words == "\r\r") << words;
    sent += !words.empty();
  }
  EXPECT_GE(sent, 3);
  EXPECT_LE(sent, 8);  // less and less often
}

TEST(Dialogue, PollsAtItsRate) {
  TlvPolling polling(10);
  int sent = 0;
  for (int i = 0; i < 1000; ++i) {
    const std::string question = polling.step(0.01 * i + 0.001);
    if (question.empty()) continue;
    EXPECT_EQ(question, std::string("\x0C\x00", 2));
    ++sent;
  }
  EXPECT_NEAR(sent, 100, 10);
}

}  // namespace
}  // namespace vir::uwb
