/// Images and calls that are wrong, and what the tracker makes of them.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstring>
#include <limits>
#include <set>
#include <stdexcept>

#include "synthetic_view.h"
#include "vir/vision/feature_tracker.h"

namespace vir::vision {
namespace {

using test::lookingDown;
using test::smallCamera;
using test::SyntheticPlane;

constexpr TimeNs kStep = 50000000;

const SyntheticPlane& plane() {
  static const SyntheticPlane instance;
  return instance;
}

Pose poseAt(int i) {
  return lookingDown(Vec3(0.02 * i, 0.01 * i, 2.0), Vec3(0.1, 0.004 * i, 0.01 * i));
}

cv::Mat view(const camera::CameraModel& camera, int i) { return plane().render(camera, poseAt(i)); }

Mat3 turn(int from, int to) {
  return (poseAt(from).q.conjugate() * poseAt(to).q).toRotationMatrix();
}

std::set<std::uint64_t> ids(const TrackedFrame& frame) {
  std::set<std::uint64_t> out;
  for (const FeatureObservation& f : frame.features) out.insert(f.id);
  return out;
}

class TrackerInput : public ::testing::Test {
 protected:
  std::shared_ptr<const camera::CameraModel> camera_ = camera::makeCamera(smallCamera());
  FeatureTracker tracker_{TrackerOptions(), camera_};
};

TEST_F(TrackerInput, NoCameraIsRefused) {
  EXPECT_THROW(FeatureTracker(TrackerOptions(), nullptr), std::invalid_argument);
}

TEST_F(TrackerInput, UnusableImagesAreNamedAndDropNothing) {
  const TrackedFrame first = tracker_.process(0, view(*camera_, 0), Mat3::Identity());
  ASSERT_GT(first.features.size(), 30u);
  cv::Mat noise(240, 376, CV_8UC1), colour(240, 376, CV_8UC3, cv::Scalar(1, 2, 3));
  cv::RNG random(3);
  random.fill(noise, cv::RNG::NORMAL, 6, 2);  // darkness as a sensor sees it
  struct Bad {
    cv::Mat image;
    std::string reason;
  };
  const std::vector<Bad> bad = {{cv::Mat(), "empty"},
                                {cv::Mat::zeros(100, 376, CV_8UC1), "376x100"},
                                {colour, "8-bit"},
                                {cv::Mat::zeros(240, 376, CV_16UC1), "8-bit"},
                                {cv::Mat::zeros(240, 376, CV_8UC1), "blank"},
                                {cv::Mat(240, 376, CV_8UC1, cv::Scalar(255)), "blank"},
                                {noise, "blank"}};
  TimeNs t = kStep;
  for (const Bad& b : bad) {
    const TrackedFrame frame = tracker_.process(t, b.image, Mat3::Identity());
    EXPECT_FALSE(frame.usable) << b.reason;
    EXPECT_NE(frame.reason.find(b.reason), std::string::npos) << frame.reason;
    EXPECT_TRUE(frame.features.empty());
    EXPECT_EQ(frame.t, t);
    t += kStep;
  }
  // The rotation handed over spans the time since the last usable image.
  const TrackedFrame again = tracker_.process(t, view(*camera_, 3), turn(0, 3));
  EXPECT_TRUE(again.usable);
  EXPECT_GT(again.continued, static_cast<int>(0.7 * static_cast<double>(first.features.size())));
  for (const FeatureObservation& f : again.features) {
    if (f.age == 0) continue;
    EXPECT_EQ(f.age, 1);
    for (const FeatureObservation& g : first.features) {
      if (g.id != f.id) continue;
      EXPECT_LT((f.bearing_rate - (f.bearing - g.bearing) / toSeconds(t)).norm(), 1e-12);
    }
  }
}

TEST_F(TrackerInput, AFaintImageIsLeftOutButNotForEver) {
  const TrackedFrame first = tracker_.process(0, view(*camera_, 0), Mat3::Identity());
  const SyntheticPlane elsewhere(0.004, 2048, 4321);
  const cv::Mat faint = elsewhere.render(*camera_, poseAt(0), 0.09, 3.0);
  const TrackedFrame dark = tracker_.process(kStep, faint, Mat3::Identity());
  EXPECT_FALSE(dark.usable);
  EXPECT_NE(dark.reason.find("faint"), std::string::npos) << dark.reason;
  EXPECT_TRUE(dark.features.empty());
  const TrackedFrame again = tracker_.process(2 * kStep, view(*camera_, 1), turn(0, 1));
  EXPECT_GT(again.continued, static_cast<int>(0.7 * static_cast<double>(first.features.size())));
  EXPECT_FALSE(tracker_.process(3 * kStep, faint, Mat3::Identity()).usable);
  EXPECT_TRUE(tracker_.process(40 * kStep, faint, Mat3::Identity()).usable);
}

TEST_F(TrackerInput, StartsInTheDark) {
  EXPECT_FALSE(tracker_.process(0, cv::Mat::zeros(240, 376, CV_8UC1), Mat3::Identity()).usable);
  EXPECT_GT(tracker_.process(kStep, view(*camera_, 0), Mat3::Identity()).detected, 30);
}

TEST_F(TrackerInput, AnotherSceneEndsAllTracksWithoutHarm) {
  const TrackedFrame first = tracker_.process(0, view(*camera_, 0), Mat3::Identity());
  const SyntheticPlane elsewhere(0.004, 2048, 1234);
  const TrackedFrame second =
      tracker_.process(kStep, elsewhere.render(*camera_, poseAt(0)), Mat3::Identity());
  EXPECT_TRUE(second.usable);
  EXPECT_LT(second.continued, 4);
  EXPECT_GT(second.detected, 30);
  EXPECT_EQ(second.lost_flow + second.lost_backward + second.lost_outlier + second.lost_crowded +
                second.continued,
            static_cast<int>(first.features.size()));
}

TEST_F(TrackerInput, FewerThanTwoTracks) {
  for (int spots = 0; spots <= 2; ++spots) {
    FeatureTracker tracker(TrackerOptions(), camera_);
    int followed = 0;
    for (int i = 0; i < 4; ++i) {
      // A ramp, so that the image is not blank, with corners only at the spots.
      cv::Mat image(240, 376, CV_8UC1);
      for (int y = 0; y < 240; ++y) image.row(y).setTo(cv::Scalar(40 + y / 4));
      for (int s = 0; s < spots; ++s) {
        cv::rectangle(image, cv::Rect(100 + 120 * s + 2 * i, 100, 9, 9), cv::Scalar(220), -1);
      }
      const TrackedFrame frame = tracker.process(i * kStep, image, Mat3::Identity());
      EXPECT_TRUE(frame.usable) << frame.reason;
      followed = frame.continued;
    }
    EXPECT_EQ(followed > 0, spots > 0);
  }
}

TEST_F(TrackerInput, ARotationThatIsNoneIsReportedAndNotUsed) {
  tracker_.process(0, view(*camera_, 0), Mat3::Identity());
  const Mat3 nan = Mat3::Constant(std::numeric_limits<double>::quiet_NaN());
  const TrackedFrame frame = tracker_.process(kStep, view(*camera_, 0), nan);
  EXPECT_TRUE(frame.usable);
  EXPECT_NE(frame.reason.find("rotation"), std::string::npos);
  EXPECT_GT(frame.continued, 30);
  EXPECT_TRUE(tracker_.process(2 * kStep, view(*camera_, 0), Mat3::Zero()).continued > 30);
}

TEST_F(TrackerInput, TimeThatDoesNotAdvanceGivesNoRate) {
  tracker_.process(kStep, view(*camera_, 0), Mat3::Identity());
  for (TimeNs t : {kStep, TimeNs{0}}) {
    for (const FeatureObservation& f :
         tracker_.process(t, view(*camera_, 1), turn(0, 1)).features) {
      EXPECT_EQ(f.bearing_rate, Vec3::Zero());
    }
  }
}

TEST_F(TrackerInput, DropAndResetNeverReuseAnId) {
  const auto first = ids(tracker_.process(0, view(*camera_, 0), Mat3::Identity()));
  const std::uint64_t gone = *first.begin();
  tracker_.stopFollowing({gone, gone, 123456789u});
  const auto second = ids(tracker_.process(kStep, view(*camera_, 0), Mat3::Identity()));
  EXPECT_EQ(second.count(gone), 0u);
  EXPECT_GT(second.size(), first.size() / 2);
  tracker_.reset();
  const TrackedFrame fresh = tracker_.process(2 * kStep, view(*camera_, 0), Mat3::Identity());
  EXPECT_EQ(fresh.continued, 0);
  EXPECT_GT(fresh.detected, 30);
  for (const std::uint64_t id : ids(fresh)) EXPECT_GT(id, *second.rbegin());
}

TEST_F(TrackerInput, SmallImages) {
  for (int size : {1, 2, 5, 16, 31, 64}) {
    CameraCalibration c = smallCamera();
    c.width = size;
    c.height = size + 3;
    FeatureTracker tracker(TrackerOptions(), camera::makeCamera(c));
    const cv::Mat image = view(*camera_, 0)(cv::Rect(100, 100, c.width, c.height));
    for (int i = 0; i < 3; ++i) tracker.process(i * kStep, image, Mat3::Identity());
  }
}

TEST_F(TrackerInput, ViewsIntoLargerImagesAndNoChangeToThem) {
  cv::Mat large(300, 500, CV_8UC1, cv::Scalar(77));
  cv::Mat inner = large(cv::Rect(40, 30, 376, 240));
  view(*camera_, 0).copyTo(inner);
  const cv::Mat copy = large.clone();
  const auto part = tracker_.process(0, inner, Mat3::Identity());
  EXPECT_EQ(cv::norm(large, copy, cv::NORM_INF), 0.0);
  FeatureTracker other(TrackerOptions(), camera_);
  const auto whole = other.process(0, view(*camera_, 0), Mat3::Identity());
  ASSERT_EQ(part.features.size(), whole.features.size());
  for (std::size_t k = 0; k < part.features.size(); ++k) {
    EXPECT_EQ(part.features[k].px, whole.features[k].px);
  }
}

TEST_F(TrackerInput, SameBytesEveryTimeAndWithAnyNumberOfThreads) {
  const int threads = cv::getNumThreads();
  std::vector<std::vector<FeatureObservation>> runs;
  for (int n : {1, 1, 2}) {
    cv::setNumThreads(n);
    FeatureTracker tracker(TrackerOptions(), camera_);
    runs.emplace_back();
    for (int i = 0; i < 6; ++i) {
      const auto frame =
          tracker.process(i * kStep, view(*camera_, i), i == 0 ? Mat3::Identity() : turn(i - 1, i));
      runs.back().insert(runs.back().end(), frame.features.begin(), frame.features.end());
    }
  }
  cv::setNumThreads(threads);
  for (std::size_t r = 1; r < runs.size(); ++r) {
    ASSERT_EQ(runs[r].size(), runs[0].size());
    for (std::size_t k = 0; k < runs[0].size(); ++k) {
      const FeatureObservation &a = runs[0][k], &b = runs[r][k];
      ASSERT_EQ(a.id, b.id);
      ASSERT_EQ(std::memcmp(a.px.data(), b.px.data(), sizeof(double) * 2), 0);
      ASSERT_EQ(std::memcmp(a.bearing_rate.data(), b.bearing_rate.data(), sizeof(double) * 3), 0);
    }
  }
}

/// Checks that every default lies within its bounds and every key has a line of explanation.
class BoundsChecker : public OptionVisitor {
 public:
  int count = 0;
  void section(const std::string& name, const std::string& doc) override {
    EXPECT_EQ(name, "Tracker");
    EXPECT_FALSE(doc.empty());
  }
  void value(const char*, bool&, const char* doc) override { seen(doc); }
  void value(const char* key, int& v, Bounds<int> b, const char* doc) override {
    EXPECT_TRUE(v >= b.min && v <= b.max) << key;
    seen(doc);
  }
  void value(const char* key, double& v, Bounds<double> b, const char* doc) override {
    EXPECT_TRUE(v >= b.min && v <= b.max) << key;
    seen(doc);
  }
  void value(const char*, std::string&, const char* doc) override { seen(doc); }
  void value(const char*, std::vector<double>&, std::size_t, const char* doc) override {
    seen(doc);
  }
  void choice(const char*, std::string&, const std::vector<std::string>&,
              const char* doc) override {
    seen(doc);
  }

 private:
  void seen(const std::string& doc) {
    EXPECT_FALSE(doc.empty());
    ++count;
  }
};

TEST(TrackerOptions, DefaultsLieWithinTheirBounds) {
  BoundsChecker checker;
  TrackerOptions options;
  describe(checker, options);
  EXPECT_EQ(checker.count, 11);
}

}  // namespace
}  // namespace vir::vision
