/// Second visits in a recording with ground truth: how many are found, how many are wrong, and how
/// long it takes. places_recording MAV0 TRUTH.tum [RECENT_S [EVERY_S [DESCRIPTORS_OUT]]]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <deque>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "recording.h"
#include "vir/places/describer.h"
#include "vir/places/loop_finder.h"
#include "vir/vision/feature_tracker.h"

using namespace vir;

namespace {

struct Sight {
  std::size_t image;
  Vec2 px;
  Vec3 bearing;
};

double cpu() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Inverse distance along `bearing` of image `at`, by the track's other sights.
places::SeenLandmark triangulate(const std::vector<Sight>& track, const Sight& at,
                                 const std::vector<Pose>& T_W_C, double focal) {
  const Pose& T0 = T_W_C[at.image];
  const Vec3 ray = T0.q * at.bearing;
  double rho = 0.3, information = 0;
  for (int step = 0; step < 10; ++step) {
    double b = 0;
    information = 1e-9;
    for (const Sight& s : track) {
      if (s.image == at.image) continue;
      const Pose& T = T_W_C[s.image];
      const Vec3 arm = T.q.conjugate() * (T0.p - T.p);
      const Vec3 y = T.q.conjugate() * ray + rho * arm;
      const Vec3 x = y.normalized();
      const Vec3 slope = (arm - x * x.dot(arm)) / y.norm();
      const Vec3 e = x - s.bearing;
      const double w = 1 / (1 + e.squaredNorm() * focal * focal);
      information += w * slope.squaredNorm();
      b += w * slope.dot(e);
    }
    rho = std::clamp(rho - b / information, 0.01, 5.0);
  }
  const double sigma = std::max(1 / (focal * std::sqrt(information)), 0.01 * rho);
  return {at.px, sigma < 0.3 * rho ? rho : 0, sigma};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const double recent_s = argc > 3 ? std::atof(argv[3]) : 4;
  const double every_s = argc > 4 ? std::atof(argv[4]) : 0.25;
  const tool::Recording rec = tool::readRecording(argv[1], argv[2]);
  const auto camera = camera::makeCamera(rec.calibration);
  vision::FeatureTracker tracker({}, camera);
  std::map<std::uint64_t, std::vector<Sight>> tracks;
  std::vector<std::vector<std::uint64_t>> of_image;
  std::vector<Pose> T_W_C;
  std::vector<cv::Mat> images;
  std::vector<TimeNs> stamps;
  TimeNs last = 0;
  for (const auto& [t, file] : rec.images) {
    Pose T_W_B;
    if (!rec.pose(t, &T_W_B)) continue;
    const cv::Mat gray = cv::imread(file, cv::IMREAD_GRAYSCALE);
    if (gray.empty()) continue;
    const auto frame = tracker.process(
        t, gray, last ? rec.gyroRotation(last, t, Vec3::Zero()) : Mat3(Mat3::Identity()));
    last = t;
    of_image.emplace_back();
    for (const auto& f : frame.features) {
      tracks[f.id].push_back({T_W_C.size(), f.px, f.bearing});
      of_image.back().push_back(f.id);
    }
    T_W_C.push_back(T_W_B * rec.T_B_C);
    images.push_back(gray);
    stamps.push_back(t);
  }
  places::LoopFinderOptions fo;
  fo.recent_s = recent_s;
  places::VerifyOptions vo;
  places::LoopFinder finder(fo, {}, vo);
  places::Describer describer({}, camera);
  std::ofstream dump;
  if (argc > 5) dump.open(argv[5], std::ios::binary | std::ios::app);

  std::vector<std::shared_ptr<PlaceKeyframe>> all;
  std::map<std::string, int> decisions;
  std::vector<double> nees, errors;
  int possible = 0, found_any = 0, right_candidate = 0, verified = 0, wrong = 0, loops = 0,
      false_loops = 0, possible_found = 0, pairs = 0;
  double describe_s = 0, add_s = 0, known = 0;
  TimeNs next = 0;
  for (std::size_t k = 0; k < images.size(); ++k) {
    if (stamps[k] < next) continue;
    next = stamps[k] + fromSeconds(every_s) - 1000000;
    auto kf = std::make_shared<PlaceKeyframe>();
    kf->id = all.size();
    kf->t = stamps[k];
    kf->T_B_C = rec.T_B_C;
    kf->T_W_B = T_W_C[k] * rec.T_B_C.inverse();
    std::vector<places::SeenLandmark> seen;
    for (const std::uint64_t id : of_image[k]) {
      const auto& track = tracks[id];
      const auto at =
          std::find_if(track.begin(), track.end(), [&](const Sight& s) { return s.image == k; });
      seen.push_back(triangulate(track, *at, T_W_C, rec.calibration.fx));
    }
    Image view;
    view.width = images[k].cols;
    view.height = images[k].rows;
    view.pixels = images[k].data;
    view.stride = images[k].step;
    const double t0 = cpu();
    kf->points = describer.points(view, T_W_C[k].q, seen);
    const double t1 = cpu();
    describe_s += t1 - t0;
    for (const auto& p : kf->points) {
      known += p.inverse_distance > 0;
      if (dump) dump.write(reinterpret_cast<const char*>(p.descriptor.data()), 32);
    }
    const double t2 = cpu();
    const auto believed = finder.add(kf);
    add_s += cpu() - t2;
    bool could = false, got = false, right = false;
    const auto near = [&](const PlaceKeyframe& o) {
      const Pose rel = o.T_W_B.inverse() * kf->T_W_B;
      return rel.p.norm() < 0.7 && rel.q.angularDistance(Quat::Identity()) < 0.35;
    };
    for (const auto& o : all) could |= toSeconds(kf->t - o->t) > recent_s && near(*o);
    for (const auto& a : finder.attempts()) {
      ++pairs;
      ++decisions[a.decision];
      const PlaceKeyframe& o = *all[a.older];
      right |= near(o);
      if (!a.verdict.found) continue;
      ++verified;
      const Pose truth = o.T_W_B.inverse() * kf->T_W_B;
      const double e = (a.verdict.found->T_older_newer.p - truth.p).norm();
      const bool bad = e > 0.3 || a.verdict.found->T_older_newer.q.angularDistance(truth.q) > 0.1;
      wrong += bad;
      if (bad) {
        std::printf(
            "  wrong: %d-%d (%s) off %.2f m, %.2f rad; true way %.2f m, %.2f rad, matches %d, "
            "inliers %d, share %.2f, sigma %.3f m\n",
            static_cast<int>(a.older), static_cast<int>(a.newer), a.decision.c_str(), e,
            a.verdict.found->T_older_newer.q.angularDistance(truth.q), truth.p.norm(),
            truth.q.angularDistance(Quat::Identity()), a.verdict.matches, a.verdict.inliers,
            a.verdict.share, std::sqrt(a.verdict.found->covariance.topLeftCorner<3, 3>().trace()));
      }
      got |= !bad;
      if (bad) continue;
      errors.push_back(e);
      nees.push_back(
          places::loopChi2(*a.verdict.found, {truth, Eigen::Matrix<double, 6, 6>::Zero()}) / 6);
    }
    for (const Loop& l : believed) {
      ++loops;
      const Pose truth =
          all[l.older]->T_W_B.inverse() * (l.newer == kf->id ? kf->T_W_B : all[l.newer]->T_W_B);
      false_loops += (l.T_older_newer.p - truth.p).norm() > 0.3;
    }
    possible += could;
    found_any += got;
    possible_found += could && got;
    right_candidate += could && right;
    all.push_back(kf);
  }
  const double n = static_cast<double>(all.size());
  std::printf("%zu keyframes, %.0f points with distance each; second visits possible %d\n",
              all.size(), known / n, possible);
  std::printf("right candidate for %d, verified right for %d (%d keyframes in all)\n",
              right_candidate, possible_found, found_any);
  std::printf("%d pairs, %d verified, %d wrong; believed %d, %d wrong\n", pairs, verified, wrong,
              loops, false_loops);
  for (const auto& [d, count] : decisions) std::printf("  %-28s %d\n", d.c_str(), count);
  if (!nees.empty()) {
    std::sort(nees.begin(), nees.end());
    std::sort(errors.begin(), errors.end());
    double sum = 0;
    for (const double v : nees) sum += v;
    std::printf("NEES/6 mean %.2f median %.2f 95 %% %.2f; error median %.4f m, 95 %% %.4f m\n",
                sum / static_cast<double>(nees.size()), nees[nees.size() / 2],
                nees[nees.size() * 95 / 100], errors[errors.size() / 2],
                errors[errors.size() * 95 / 100]);
  }
  std::printf("describe %.2f ms, find %.2f ms per keyframe; index %.1f MB\n", 1000 * describe_s / n,
              1000 * add_s / n, static_cast<double>(finder.index().bytes()) / 1e6);
  return 0;
}
