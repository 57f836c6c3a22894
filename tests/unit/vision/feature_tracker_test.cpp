#include "vir/vision/feature_tracker.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <map>

#include "synthetic_view.h"

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

TrackerOptions smallOptions() {
  TrackerOptions o;
  o.max_tracks = 80;
  o.min_distance_px = 20;
  o.grid_cell_px = 40;
  return o;
}

Mat3 relative(const Pose& before, const Pose& now) {
  return (before.q.conjugate() * now.q).toRotationMatrix();
}

/// Follows the features over `poses` and compares each with the exact image of its first sight.
struct Flight {
  std::vector<TrackedFrame> frames;
  double rms = 0, worst = 0;  ///< [px], of all features older than one image
  long n = 0;

  Flight(const camera::CameraModel& camera, FeatureTracker* tracker, const std::vector<Pose>& poses,
         const std::vector<double>& gain, const std::vector<Mat3>& rotation) {
    std::map<std::uint64_t, std::pair<std::size_t, Vec2>> first;
    double sum = 0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const cv::Mat image = plane().render(camera, poses[i], gain[i], gain[i] == 1.0 ? 0.0 : 10.0);
      frames.push_back(tracker->process(static_cast<TimeNs>(i) * kStep, image, rotation[i]));
      for (const FeatureObservation& f : frames.back().features) {
        const auto [it, is_new] = first.emplace(f.id, std::make_pair(i, f.px));
        EXPECT_EQ(is_new, f.age == 0);
        Vec2 truth;
        if (is_new || !plane().transfer(camera, poses[it->second.first], poses[i],
                                        it->second.second, &truth)) {
          continue;
        }
        const double error = (f.px - truth).norm();
        sum += error * error;
        worst = std::max(worst, error);
        ++n;
      }
    }
    rms = std::sqrt(sum / static_cast<double>(std::max(n, 1L)));
  }
};

std::vector<Mat3> rotations(const std::vector<Pose>& poses) {
  std::vector<Mat3> out = {Mat3::Identity()};
  for (std::size_t i = 1; i < poses.size(); ++i) out.push_back(relative(poses[i - 1], poses[i]));
  return out;
}

/// Sideways, rising and turning: 2 m above the plane.
std::vector<Pose> sweep(int n, double turn_rad = 0.01) {
  std::vector<Pose> poses;
  for (int i = 0; i < n; ++i) {
    poses.push_back(lookingDown(Vec3(0.03 * i, 0.015 * i, 2.0 + 0.02 * i),
                                Vec3(0.2 + turn_rad * i, -0.1, 2 * turn_rad * i)));
  }
  return poses;
}

double survival(const TrackedFrame& before, const TrackedFrame& now) {
  return static_cast<double>(now.continued) / static_cast<double>(before.features.size());
}

TEST(FeatureTracker, TracksLandWhereTheyBelong) {
  const auto camera = camera::makeCamera(smallCamera());
  FeatureTracker tracker(smallOptions(), camera);
  const auto poses = sweep(20);
  const Flight flight(*camera, &tracker, poses, std::vector<double>(20, 1.0), rotations(poses));
  EXPECT_GT(flight.n, 800);
  EXPECT_LT(flight.rms, 0.06);
  EXPECT_LT(flight.worst, 0.5);
  for (std::size_t i = 1; i < flight.frames.size(); ++i) {
    EXPECT_GT(survival(flight.frames[i - 1], flight.frames[i]), 0.8) << "image " << i;
  }
  EXPECT_GT(flight.frames.back().features.front().age, 10);
}

TEST(FeatureTracker, WorksWithAnEquidistantCamera) {
  const auto camera = camera::makeCamera(smallCamera(Distortion::equidistant));
  FeatureTracker tracker(smallOptions(), camera);
  const auto poses = sweep(12);
  const Flight flight(*camera, &tracker, poses, std::vector<double>(12, 1.0), rotations(poses));
  EXPECT_GT(flight.n, 400);
  EXPECT_LT(flight.rms, 0.06);
}

TEST(FeatureTracker, SurvivesExposureJumps) {
  const auto camera = camera::makeCamera(smallCamera());
  FeatureTracker tracker(smallOptions(), camera);
  const auto poses = sweep(12);
  const std::vector<double> gain = {1, 1, 0.5, 0.5, 0.9, 1.3, 0.4, 0.35, 1, 0.7, 0.75, 0.8};
  const Flight flight(*camera, &tracker, poses, gain, rotations(poses));
  for (std::size_t i = 1; i < flight.frames.size(); ++i) {
    EXPECT_GT(survival(flight.frames[i - 1], flight.frames[i]), 0.75) << "image " << i;
  }
  EXPECT_LT(flight.rms, 0.06);
}

TEST(FeatureTracker, FollowsNinetyDegreesPerSecondWithTheGyro) {
  // 4.5 deg per image: 31 px with this focal length.
  CameraCalibration calibration = smallCamera();
  calibration.fx = calibration.fy = 400.0;
  const auto camera = camera::makeCamera(calibration);
  std::vector<Pose> poses;
  for (int i = 0; i < 8; ++i) {
    poses.push_back(lookingDown(Vec3(0.02 * i, 0, 2.0), Vec3(0, 0.0785 * (i - 4), 0)));
  }
  FeatureTracker with(smallOptions(), camera), without(smallOptions(), camera);
  const std::vector<double> gain(poses.size(), 1.0);
  const Flight good(*camera, &with, poses, gain, rotations(poses));
  const Flight bad(*camera, &without, poses, gain,
                   std::vector<Mat3>(poses.size(), Mat3::Identity()));
  EXPECT_LT(good.rms, 0.05);
  EXPECT_GT(good.n, 250);
  // Without the gyro fewer may be found, but what is reported must be right.
  EXPECT_LT(bad.rms, 0.1);
  EXPECT_LE(bad.n, good.n);
}

TEST(FeatureTracker, ToleratesAGyroBias) {
  const auto camera = camera::makeCamera(smallCamera());
  FeatureTracker exact(smallOptions(), camera), biased(smallOptions(), camera);
  const auto poses = sweep(10);
  std::vector<Mat3> wrong = rotations(poses);
  for (Mat3& R : wrong) R = R * expSO3(Vec3(0.02, -0.06, 0.05) * 0.05);
  const std::vector<double> gain(poses.size(), 1.0);
  const Flight a(*camera, &exact, poses, gain, rotations(poses));
  const Flight b(*camera, &biased, poses, gain, wrong);
  EXPECT_GT(b.n, 0.95 * static_cast<double>(a.n));
  EXPECT_LT(b.rms, 0.06);
}

/// A burst of false readings: what turned goes on turning.
TEST(FeatureTracker, FollowsWhereTheRotationGivenIsFarFromTheTruth) {
  const auto camera = camera::makeCamera(smallCamera());
  FeatureTracker exact(smallOptions(), camera), told(smallOptions(), camera);
  const auto poses = sweep(10, 0.03);
  std::vector<Mat3> wrong = rotations(poses);
  for (const std::size_t i : {5u, 6u}) wrong[i] = wrong[i] * expSO3(Vec3(0.25, -0.3, 0.2));
  const std::vector<double> gain(poses.size(), 1.0);
  const Flight a(*camera, &exact, poses, gain, rotations(poses));
  const Flight b(*camera, &told, poses, gain, wrong);
  EXPECT_GT(b.n, 0.9 * static_cast<double>(a.n));
  EXPECT_LT(b.rms, 0.06);
}

TEST(FeatureTracker, DropsWhatMovesOnItsOwn) {
  const auto camera = camera::makeCamera(smallCamera());
  FeatureTracker tracker(smallOptions(), camera);
  const auto poses = sweep(5);
  const SyntheticPlane other(0.004, 512, 99);
  const cv::Mat thing =
      other.render(*camera, lookingDown(Vec3(0, 0, 2)))(cv::Rect(120, 60, 90, 90));
  const auto rotation = rotations(poses);
  std::vector<TrackedFrame> frames;
  std::vector<cv::Rect> at;
  for (int i = 0; i < 5; ++i) {
    cv::Mat image = plane().render(*camera, poses[static_cast<std::size_t>(i)]);
    at.emplace_back(130 - 3 * i, 60 + 6 * i, 90, 90);
    thing.copyTo(image(at.back()));
    frames.push_back(tracker.process(i * kStep, image, rotation[static_cast<std::size_t>(i)]));
  }
  int still_followed = 0, outside = 0;
  for (const FeatureObservation& f : frames.back().features) {
    const cv::Rect inner(at.back().x + 8, at.back().y + 8, 74, 74);
    const bool on_thing =
        inner.contains(cv::Point(static_cast<int>(f.px.x()), static_cast<int>(f.px.y())));
    if (on_thing && f.age >= 2) ++still_followed;
    if (!on_thing && f.age >= 3) ++outside;
  }
  int at_first = 0;
  for (const FeatureObservation& f : frames.front().features) {
    at_first +=
        at.front().contains(cv::Point(static_cast<int>(f.px.x()), static_cast<int>(f.px.y())));
  }
  EXPECT_GE(at_first, 6);
  // One may happen to move along its epipolar line.
  EXPECT_LE(still_followed, 1);
  EXPECT_GT(outside, 25);
}

TEST(FeatureTracker, ObservationsAreConsistent) {
  const auto camera = camera::makeCamera(smallCamera());
  TrackerOptions options = smallOptions();
  FeatureTracker tracker(options, camera);
  const auto poses = sweep(4);
  std::map<std::uint64_t, Vec3> before;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Mat3 R = i == 0 ? Mat3::Identity() : relative(poses[i - 1], poses[i]);
    const TrackedFrame frame =
        tracker.process(static_cast<TimeNs>(i) * kStep, plane().render(*camera, poses[i]), R);
    EXPECT_EQ(frame.t, static_cast<TimeNs>(i) * kStep);
    EXPECT_TRUE(frame.usable);
    EXPECT_EQ(frame.continued + frame.detected, static_cast<int>(frame.features.size()));
    EXPECT_LE(static_cast<int>(frame.features.size()), options.max_tracks);
    std::map<std::uint64_t, Vec3> now;
    for (std::size_t k = 0; k < frame.features.size(); ++k) {
      const FeatureObservation& f = frame.features[k];
      if (k > 0) {
        EXPECT_LT(frame.features[k - 1].id, f.id);
      }
      Vec2 px;
      Mat23 J;
      ASSERT_TRUE(camera->project(f.bearing, &px, &J));
      EXPECT_LT((px - f.px).norm(), 1e-9);
      EXPECT_LT((J - f.dpx_dbearing).norm(), 1e-9);
      EXPECT_LT((f.dpx_dbearing * f.bearing).norm(), 1e-9);
      if (f.age == 0) {
        EXPECT_EQ(f.bearing_rate, Vec3::Zero());
        for (std::size_t j = 0; j < k; ++j) {
          EXPECT_GT((frame.features[j].px - f.px).norm(), options.min_distance_px - 1e-3);
        }
      } else {
        EXPECT_LT((f.bearing_rate - (f.bearing - before.at(f.id)) / 0.05).norm(), 1e-12);
      }
      now[f.id] = f.bearing;
    }
    before = now;
  }
}

}  // namespace
}  // namespace vir::vision
