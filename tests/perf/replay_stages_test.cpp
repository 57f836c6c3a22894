/// The two halves of the estimator can be run apart, and give what they gave together.
#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <vector>

#include "vir_test_paths.h"
#include "vir_test_shell.h"

namespace vir {
namespace {

const std::string kTool = test::quoted(test::buildDir() + "/bin/replay_stages");
const std::string kSample = test::quoted(test::sourceDir() + "/rawlog/two_A.rawlog");
const std::string kIni = test::quoted(test::sourceDir() + "/ini/euroc.ini");

/// The six numbers behind the name of a stage.
std::vector<double> row(const std::string& text, const std::string& stage) {
  std::vector<double> v(6, -1);
  const std::size_t at = text.find("\n" + stage);
  if (at == std::string::npos) return v;
  std::sscanf(text.c_str() + at + 1 + stage.size(), " | %lf %lf %lf | %lf %lf %lf", &v[0], &v[1],
              &v[2], &v[3], &v[4], &v[5]);
  return v;
}

TEST(ReplayStages, TheSampleIsReplayedStageByStage) {
  const test::Outcome out = test::shell(kTool + " " + kSample + " --ini " + kIni + " --rounds 1");
  ASSERT_EQ(out.code, 0) << out.text;
  int images = 0, states = 0, keyframes = 0;
  ASSERT_EQ(std::sscanf(out.text.c_str(), "%d images, %d of them with a state, %d keyframes",
                        &images, &states, &keyframes),
            3)
      << out.text;
  EXPECT_GT(states, images / 2);
  EXPECT_GT(keyframes, 20);
  EXPECT_LT(keyframes, states);
  for (const char* stage : {"decoding", "front end", "  flow", "back end", "  optimise"}) {
    const std::vector<double> v = row(out.text, stage);
    EXPECT_GT(v[2], 0) << stage << "\n" << out.text;
    EXPECT_GT(v[5], 0) << stage << "\n" << out.text;
    EXPECT_GE(v[1], v[0]) << stage;
  }
  // A keyframe's window is solved as a whole.
  EXPECT_GT(row(out.text, "  optimise")[0], row(out.text, "  optimise")[3]) << out.text;
}

TEST(ReplayStages, WrongUsageIsRefusedByName) {
  for (const char* arguments :
       {"", "--no-such-option", "X.rawlog --rounds 0", "X.rawlog --set Window.no_such_key=1",
        "X.rawlog --set Estimator.other_cameras=auto"}) {
    const test::Outcome out = test::shell(kTool + " " + arguments);
    EXPECT_EQ(out.code, 2) << arguments << ": " << out.text;
    EXPECT_FALSE(out.text.empty()) << arguments;
  }
  const test::Outcome missing = test::shell(kTool + " no_such.rawlog");
  EXPECT_EQ(missing.code, 1) << missing.text;
  EXPECT_TRUE(test::contains(missing.text, "no_such.rawlog")) << missing.text;
}

}  // namespace
}  // namespace vir
