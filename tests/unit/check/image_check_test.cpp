#include "vir/check/image_check.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>

#include "found.h"

namespace vir::check {
namespace {

constexpr TimeNs kDate = 1400000000000000000;

/// 20 images of a chequered place, each a little different.
std::vector<Finding> findingsOf(double gain, double offset, int type = CV_8UC1) {
  ImageCheck check("CAM0");
  for (int i = 0; i < 20; ++i) {
    cv::Mat m(48, 64, CV_8UC1);
    for (int y = 0; y < m.rows; ++y) {
      for (int x = 0; x < m.cols; ++x) {
        const double v = ((x + i) / 8 + y / 8) % 2 == 0 ? 200 : 60;
        m.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(gain * v + offset);
      }
    }
    cv::Mat other;
    m.convertTo(other, type);
    check.add(i * 50000000LL, other);
  }
  return check.findings(64, 48);
}

TEST(ImageCheck, NamesWhatIsWrongWithTheLight) {
  EXPECT_EQ(seriousKinds(findingsOf(1, 0)), Kinds{});
  EXPECT_EQ(seriousKinds(findingsOf(0.1, 0)), Kinds{"low_contrast"});
  EXPECT_EQ(seriousKinds(findingsOf(0.02, 28)), Kinds{"blank"});
  EXPECT_EQ(seriousKinds(findingsOf(0.15, 0)), Kinds{"dark"});
  EXPECT_EQ(seriousKinds(findingsOf(1, 0, CV_16UC1)), Kinds{"unreadable"});
}

/// 20 s at 10 Hz, the image of number `i` made by `change`.
template <typename Change>
ImageCheck watched(Change change) {
  ImageCheck check("CAM0");
  for (int i = 0; i < 200; ++i) {
    cv::Mat m(48, 64, CV_8UC1);
    for (int y = 0; y < m.rows; ++y) {
      for (int x = 0; x < m.cols; ++x) {
        m.at<std::uint8_t>(y, x) = ((x + i) / 8 + y / 8) % 2 == 0 ? 200 : 60;
      }
    }
    change(i, &m);
    check.add(kDate + i * 100000000LL, m);
  }
  return check;
}

TEST(ImageCheck, SaysWhenImagesAreDarkOrBlinded) {
  struct Case {
    double gain, offset;
    const char *kind, *said;
  };
  for (const Case& c : {Case{0, 1, "blank", "images are black for 5 s, from 7 s after"},
                        Case{0, 254, "blank", "images are white for 5 s, from 7 s after"},
                        Case{0, 128, "blank", "images are as good as blank for 5 s, from 7 s"},
                        Case{0.1, 0, "dark", "images are dark for 5 s, from 7 s after"},
                        Case{0.1, 235, "bright", "images are overexposed for 5 s, from 7 s"}}) {
    const ImageCheck check = watched([&](int i, cv::Mat* m) {
      if (i >= 70 && i < 120) m->convertTo(*m, -1, c.gain, c.offset);
    });
    const auto findings = check.findings(64, 48, [](TimeNs, TimeNs) { return true; });
    ASSERT_EQ(seriousKinds(findings), Kinds{c.kind}) << c.said;
    EXPECT_EQ(findings[0].what.rfind(c.said, 0), 0u) << findings[0].what;
  }
  // What the IMU bridges is said, and no more.
  const ImageCheck brief = watched([](int i, cv::Mat* m) {
    if (i >= 70 && i < 90) m->setTo(0);
  });
  const auto noted = brief.findings(64, 48);
  EXPECT_EQ(seriousKinds(noted), Kinds{});
  ASSERT_EQ(noted.size(), 1u);
  EXPECT_EQ(noted[0].kind, "blank");
  const ImageCheck single = watched([](int i, cv::Mat* m) {
    if (i % 20 == 0) m->setTo(0);
  });
  EXPECT_EQ(seriousKinds(single.findings(64, 48)), Kinds{});
  const ImageCheck two = watched([](int i, cv::Mat* m) {
    if ((i >= 20 && i < 40) || (i >= 100 && i < 130)) m->setTo(0);
  });
  const auto findings = two.findings(64, 48);
  ASSERT_EQ(seriousKinds(findings), Kinds{"blank"});
  EXPECT_EQ(findings[0].what,
            "images are black for 3 s, from 10 s after the first image on, and 1 more time: 5 s "
            "in all");
}

TEST(ImageCheck, SaysWhenTheCameraHangs) {
  cv::Mat held;
  const ImageCheck check = watched([&](int i, cv::Mat* m) {
    if (i == 50) held = m->clone();
    if (i > 50 && i <= 100) held.copyTo(*m);
  });
  TimeNs asked_from = 0, asked_to = 0;
  const auto moving = [&](bool answer) {
    return [&, answer](TimeNs from, TimeNs to) {
      asked_from = from;
      asked_to = to;
      return std::optional<bool>(answer);
    };
  };
  const auto findings = check.findings(64, 48, moving(true));
  ASSERT_EQ(seriousKinds(findings), Kinds{"frozen"});
  EXPECT_NE(findings[0].what.find("for 5 s, from 5 s after"), std::string::npos)
      << findings[0].what;
  EXPECT_EQ(asked_from, kDate + 5250000000);
  EXPECT_EQ(asked_to, kDate + 9750000000);
  // It may as well stand, or nobody knows.
  EXPECT_EQ(seriousKinds(check.findings(64, 48, moving(false))), Kinds{});
  EXPECT_EQ(seriousKinds(check.findings(64, 48)), Kinds{});
  const ImageCheck twice = watched([&](int i, cv::Mat* m) {
    if (i % 3 == 0) held = m->clone();
    held.copyTo(*m);
  });
  EXPECT_EQ(seriousKinds(twice.findings(64, 48, moving(true))), Kinds{"frozen"});
}

/// What a hanging camera shows may be a wall: that it hangs is the cause.
TEST(ImageCheck, AHangingImageOfLittleContrastHangs) {
  cv::Mat held;
  const ImageCheck check = watched([&](int i, cv::Mat* m) {
    if (i == 50) {
      held = m->clone();
      held.convertTo(held, CV_8UC1, 0.1, 100);
    }
    if (i > 50 && i <= 100) held.copyTo(*m);
  });
  const auto moves = [](TimeNs, TimeNs) { return std::optional<bool>(true); };
  EXPECT_EQ(seriousKinds(check.findings(64, 48, moves)), Kinds{"frozen"});
  const auto still = [](TimeNs, TimeNs) { return std::optional<bool>(false); };
  EXPECT_EQ(seriousKinds(check.findings(64, 48, still)), Kinds{"low_contrast"});
}

TEST(ImageCheck, ACameraBesideTheFirstLeavesTheOthers) {
  const ImageCheck check = watched([](int i, cv::Mat* m) {
    if (i >= 50 && i < 100) m->setTo(0);
  });
  for (const bool further : {false, true}) {
    const auto findings = check.findings(64, 48, {}, further);
    ASSERT_EQ(seriousKinds(findings), Kinds{"blank"});
    EXPECT_NE(findings[0].remedy.find(further ? "a run has the other cameras" : "the IMU alone"),
              std::string::npos)
        << findings[0].remedy;
  }
}

TEST(ImageCheck, SaysThatImagesComeTwice) {
  cv::Mat held;
  int every = 0;
  const auto doubled = [&](int i, cv::Mat* m) {
    if (i % every == 1) held.copyTo(*m);
    held = m->clone();
  };
  for (const int n : {2, 10}) {
    every = n;
    const ImageCheck check = watched(doubled);
    EXPECT_EQ(seriousKinds(check.findings(64, 48)), Kinds{"frozen"}) << n;
    const auto answers = [](bool answer) {
      return [answer](TimeNs, TimeNs) { return std::optional<bool>(answer); };
    };
    EXPECT_EQ(seriousKinds(check.findings(64, 48, answers(true))), Kinds{"frozen"}) << n;
    EXPECT_EQ(seriousKinds(check.findings(64, 48, answers(false))), Kinds{}) << n;
  }
  every = 40;  // a slip now and then
  EXPECT_EQ(seriousKinds(watched(doubled).findings(64, 48)), Kinds{});
}

TEST(ImageCheck, NamesAnotherSize) {
  ImageCheck check("CAM0");
  cv::Mat m(48, 64, CV_8UC1, cv::Scalar(100));
  m.colRange(0, 32).setTo(200);
  check.add(0, m);
  EXPECT_EQ(seriousKinds(check.findings(64, 48)), Kinds{});
  EXPECT_EQ(seriousKinds(check.findings(752, 480)), Kinds{"image_size"});
}

}  // namespace
}  // namespace vir::check
