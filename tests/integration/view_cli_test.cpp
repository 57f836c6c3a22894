/// vir-slam view: a run as a film.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "vir_test_paths.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using test::contains;
using test::quoted;

const std::string kSample = test::sourceDir() + "/rawlog/two_A.rawlog";

/// Pixels of this colour (BGR, give or take a film's losses).
int count(const cv::Mat& picture, const cv::Scalar& colour) {
  const cv::Scalar give(60, 60, 60);
  cv::Mat found;
  cv::inRange(picture, colour - give, colour + give, found);
  return cv::countNonZero(found);
}

TEST(ViewCli, AFilmHasImageTracksAndPath) {
  const test::TempFolder folder;
  const std::string film = (folder / "run.mp4").string();
  const test::Outcome outcome = test::virSlam("view " + quoted(kSample) + " --video " +
                                              quoted(film) + " --start-s 4 --end-s 9 --speed 2");
  ASSERT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_TRUE(contains(outcome.text, "wrote " + film)) << outcome.text;
  cv::VideoCapture capture(film);
  ASSERT_TRUE(capture.isOpened());
  EXPECT_NEAR(capture.get(cv::CAP_PROP_FRAME_COUNT), 50, 3) << "5 s, twice as fast, 20 per second";
  cv::Mat first, last;
  capture.read(first);
  for (cv::Mat next; capture.read(next);) next.copyTo(last);
  ASSERT_EQ(last.size(), cv::Size(1200, 520));
  const cv::Rect image(0, 0, 720, 480), map(720, 0, 480, 480);
  const cv::Scalar green(90, 220, 0), blue(178, 114, 0);
  EXPECT_GT(count(last(image), green), 100) << "tracks";
  EXPECT_GT(count(last(map), blue), 200) << "path";
  EXPECT_EQ(count(last(map), green), 0);
  EXPECT_GT(cv::norm(first(image), last(image), cv::NORM_L1) / (3.0 * image.area()), 5)
      << "it moves";
}

TEST(ViewCli, ARunFolderIsSeenAgain) {
  const test::TempFolder folder;
  const std::string run = (folder / "run").string(), film = (folder / "run.avi").string();
  ASSERT_EQ(test::virSlam("run " + quoted(kSample) + " --out " + quoted(run)).code, 0);
  const test::Outcome outcome =
      test::virSlam("view " + quoted(run) + " --video " + quoted(film) + " --end-s 3");
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_TRUE(cv::VideoCapture(film).isOpened());
}

TEST(ViewCli, WhatCannotBeShownIsSaid) {
  const test::TempFolder folder;
  const test::Outcome no_display = test::shell(
      "DISPLAY= " + quoted(test::buildDir() + "/bin/vir-slam") + " view " + quoted(kSample));
  EXPECT_EQ(no_display.code, 1);
  EXPECT_TRUE(contains(no_display.text, "--video FILE.mp4")) << no_display.text;
  const test::Outcome no_folder = test::virSlam("view " + quoted(kSample) + " --end-s 3 --video " +
                                                quoted((folder / "nowhere" / "a.mp4").string()));
  EXPECT_EQ(no_folder.code, 1);
  EXPECT_TRUE(contains(no_folder.text, "cannot write the film")) << no_folder.text;
  EXPECT_EQ(test::virSlam("view " + quoted((folder / "no.rawlog").string())).code, 2);
}

}  // namespace
}  // namespace vir
