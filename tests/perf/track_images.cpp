/// Runs the tracker over an EuRoC folder and says how good its tracks are.
///   track_images MAV0 [truth=FILE.tum] [bias=x,y,z] [rotation=gyro|truth|none] [draw=PREFIX]
///                [frames=N] [OPTION=VALUE]...
/// With ground truth each track is triangulated from the true poses; what is left is the tracker's
/// error. OPTION is any key of [Tracker].
#include <Eigen/Dense>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "motion_filter.h"
#include "recording.h"
#include "vir/vision/feature_tracker.h"

using namespace vir;
using namespace vir::tool;

namespace {

using Arguments = std::map<std::string, std::string>;

class ArgumentReader : public OptionVisitor {
 public:
  explicit ArgumentReader(const Arguments& a) : arguments_(a) {}
  void section(const std::string&, const std::string&) override {}
  void value(const char* key, bool& v, const char*) override { read(key, &v); }
  void value(const char* key, int& v, Bounds<int>, const char*) override { read(key, &v); }
  void value(const char* key, double& v, Bounds<double>, const char*) override { read(key, &v); }
  void value(const char* key, std::string& v, const char*) override { read(key, &v); }
  void value(const char*, std::vector<double>&, std::size_t, const char*) override {}
  void choice(const char* key, std::string& v, const std::vector<std::string>&,
              const char*) override {
    read(key, &v);
  }

 private:
  template <typename T>
  void read(const char* key, T* v) {
    const auto it = arguments_.find(key);
    if (it == arguments_.end()) return;
    std::istringstream in(it->second);
    in >> *v;
  }
  const Arguments& arguments_;
};

struct Sighting {
  std::size_t image;
  Vec2 px;
  Vec3 bearing;
};
using Tracks = std::map<std::uint64_t, std::vector<Sighting>>;

double quantile(std::vector<double> v, double q) {
  if (v.empty()) return 0.0;
  std::sort(v.begin(), v.end());
  return v[static_cast<std::size_t>(q * static_cast<double>(v.size() - 1))];
}

/// Robust least squares point from the true camera poses; residual [px] of each sighting. Empty
/// where there is too little parallax.
std::vector<Vec2> residuals(const std::vector<Sighting>& s, const std::vector<Pose>& T_W_C,
                            const camera::CameraModel& camera) {
  Mat3 H = Mat3::Zero();
  Vec3 g = Vec3::Zero();
  double parallax = 0.0;
  const Vec3 first = T_W_C[s[0].image].q * s[0].bearing;
  for (const Sighting& o : s) {
    const Vec3 ray = T_W_C[o.image].q * o.bearing;
    const Mat3 P = Mat3::Identity() - ray * ray.transpose();
    H += P;
    g += P * T_W_C[o.image].p;
    parallax = std::max(parallax, std::acos(std::min(1.0, first.dot(ray))));
  }
  if (parallax < 0.03) return {};
  Vec3 x = H.ldlt().solve(g);
  std::vector<Vec2> r(s.size());
  for (int iteration = 0; iteration < 10; ++iteration) {
    H = Mat3::Identity() * 1e-9;
    g.setZero();
    for (std::size_t i = 0; i < s.size(); ++i) {
      const Pose T_C_W = T_W_C[s[i].image].inverse();
      Vec2 px;
      Mat23 J;
      if (!camera.project(T_C_W * x, &px, &J)) return {};
      r[i] = s[i].px - px;
      const Mat23 A = J * T_C_W.R();
      const double w = 1.0 / (1.0 + r[i].squaredNorm());
      H += w * A.transpose() * A;
      g += w * A.transpose() * r[i];
    }
    x += H.ldlt().solve(g);
  }
  return r;
}

void reportAccuracy(const Tracks& tracks, const std::vector<Pose>& T_W_C,
                    const camera::CameraModel& cam) {
  struct Bin {
    int low, high;
    double sum = 0, steps = 0;
    long n = 0, n_steps = 0;
  };
  std::vector<Bin> bins = {{4, 8}, {8, 16}, {16, 32}, {32, 64}, {64, 1 << 30}};
  std::vector<double> all, track_rms;
  for (const auto& [id, s] : tracks) {
    if (s.size() < 4) continue;
    const auto r = residuals(s, T_W_C, cam);
    if (r.empty()) continue;
    double sum = 0;
    for (const Vec2& e : r) {
      sum += e.squaredNorm();
      all.push_back(std::abs(e.x()));
      all.push_back(std::abs(e.y()));
    }
    track_rms.push_back(std::sqrt(0.5 * sum / static_cast<double>(r.size())));
    for (Bin& b : bins) {
      if (static_cast<int>(s.size()) < b.low || static_cast<int>(s.size()) >= b.high) continue;
      // Wrong tracks would hide the accuracy of good ones: counted in the tails instead.
      if (track_rms.back() > 2.0) continue;
      b.sum += sum;
      b.n += 2 * static_cast<long>(r.size());
      for (std::size_t i = 1; i < r.size(); ++i) b.steps += (r[i] - r[i - 1]).squaredNorm();
      b.n_steps += 2 * static_cast<long>(r.size() - 1);
    }
  }
  double sum = 0, good = 0;
  long n_good = 0;
  for (double e : all) {
    sum += e * e;
    if (e < 2.0) {
      good += e * e;
      ++n_good;
    }
  }
  const auto share = [&](double limit) {
    return 100.0 *
           static_cast<double>(
               std::count_if(all.begin(), all.end(), [&](double e) { return e > limit; })) /
           static_cast<double>(std::max<std::size_t>(all.size(), 1));
  };
  std::printf(
      "residual per axis [px]: tracks %zu, rms %.3f, rms below 2 px %.3f, |r| 50%% %.3f 68%% "
      "%.3f 95%% %.3f 99%% %.3f; above 1 px %.2f %%, 2 px %.2f %%, 5 px %.2f %%; tracks with "
      "rms above 1 px %.2f %%\n",
      track_rms.size(), std::sqrt(sum / static_cast<double>(std::max<std::size_t>(all.size(), 1))),
      std::sqrt(good / static_cast<double>(std::max(n_good, 1L))), quantile(all, 0.5),
      quantile(all, 0.68), quantile(all, 0.95), quantile(all, 0.99), share(1.0), share(2.0),
      share(5.0),
      100.0 *
          static_cast<double>(
              std::count_if(track_rms.begin(), track_rms.end(), [](double e) { return e > 1.0; })) /
          static_cast<double>(std::max<std::size_t>(track_rms.size(), 1)));
  std::printf("by track length (rms px | rms step px):");
  for (const Bin& b : bins) {
    std::printf("  %d+: %.3f | %.3f", b.low,
                std::sqrt(b.sum / static_cast<double>(std::max(b.n, 1L))),
                std::sqrt(b.steps / static_cast<double>(std::max(b.n_steps, 1L))));
  }
  std::printf("\n");
}

/// Distance from the epipolar line between images `gap` apart, with the relative pose fitted to the
/// tracks themselves: needs no ground truth, sees only one of two axes.
void reportEpipolar(const Tracks& tracks, std::size_t images, std::size_t gap,
                    const std::vector<Mat3>& R_C0_C, const camera::CameraModel& camera) {
  std::vector<double> all;
  for (std::size_t i = 0; i + gap < images; i += 5) {
    std::vector<BearingPair> pairs;
    double parallax = 0;
    const Mat3 R = R_C0_C[i].transpose() * R_C0_C[i + gap];
    for (const auto& [id, s] : tracks) {
      if (s.front().image > i || s.back().image < i + gap) continue;
      BearingPair p;
      for (const Sighting& o : s) {
        if (o.image == i) p.b0 = o.bearing;
        if (o.image == i + gap) p.b1 = o.bearing;
      }
      Vec2 px;
      camera.project(p.b1, &px, &p.J1);
      parallax += (p.b0 - R * p.b1).norm();
      pairs.push_back(p);
    }
    if (pairs.size() < 20 || parallax < 0.02 * static_cast<double>(pairs.size())) continue;
    const MotionVerdict v = filterByMotion(pairs, R, 0.02, 2.0);
    if (v.direction.isZero()) continue;
    const Mat3 R_fit = R * expSO3(v.rotation_correction);
    for (const BearingPair& p : pairs) {
      const Vec3 m = R_fit.transpose() * v.direction.cross(p.b0);
      const Vec2 g = (p.J1 * p.J1.transpose()).inverse() * p.J1 * m;
      all.push_back(std::abs(m.dot(p.b1)) / g.norm());
    }
  }
  const auto share = [&](double limit) {
    return 100.0 *
           static_cast<double>(
               std::count_if(all.begin(), all.end(), [&](double e) { return e > limit; })) /
           static_cast<double>(std::max<std::size_t>(all.size(), 1));
  };
  std::printf(
      "epipolar distance over %zu images [px]: n %zu, 50%% %.3f 68%% %.3f 95%% %.3f; above 1 px "
      "%.2f %%, 2 px "
      "%.2f %%\n",
      gap, all.size(), quantile(all, 0.5), quantile(all, 0.68), quantile(all, 0.95), share(1.0),
      share(2.0));
}

void draw(const cv::Mat& gray, const vision::TrackedFrame& frame, const Tracks& tracks,
          std::size_t image, const std::string& file) {
  cv::Mat canvas;
  cv::cvtColor(gray, canvas, cv::COLOR_GRAY2BGR);
  for (const vision::FeatureObservation& f : frame.features) {
    const auto& s = tracks.at(f.id);
    const double u = std::min(1.0, f.age / 30.0);
    const cv::Scalar colour(255 * (1 - u), 60, 255 * u);
    for (std::size_t i = s.size(); i-- > 1 && s[i].image + 10 > image;) {
      cv::line(canvas, cv::Point2d(s[i].px.x(), s[i].px.y()),
               cv::Point2d(s[i - 1].px.x(), s[i - 1].px.y()), colour, 1, cv::LINE_AA);
    }
    cv::circle(canvas, cv::Point2d(f.px.x(), f.px.y()), 3, colour, 1, cv::LINE_AA);
  }
  cv::imwrite(file, canvas);
}

int run(int argc, char** argv) {
  if (argc < 2) throw std::runtime_error("usage: track_images MAV0 [KEY=VALUE]...");
  Arguments a;
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    const std::size_t eq = word.find('=');
    if (eq == std::string::npos) throw std::runtime_error("not KEY=VALUE: " + word);
    a[word.substr(0, eq)] = word.substr(eq + 1);
  }
  cv::setNumThreads(1);
  const Recording r = readRecording(argv[1], a["truth"]);
  const auto camera = camera::makeCamera(r.calibration);
  vision::TrackerOptions options;
  ArgumentReader reader(a);
  describe(reader, options);
  vision::FeatureTracker tracker(options, camera);
  Vec3 bias = Vec3::Zero();
  if (!a["bias"].empty()) bias = Eigen::Map<const Vec3>(numbers(a["bias"]).data());
  const std::size_t frames =
      std::min(r.images.size(), a["frames"].empty() ? r.images.size() : std::stoul(a["frames"]));

  Tracks tracks;
  std::vector<Pose> T_W_C(frames);
  std::vector<Mat3> R_C0_C;
  double cpu = 0, pyramid = 0, flow = 0, detect = 0, count = 0, count_min = 1e9;
  long lost[3] = {0, 0, 0}, detected = 0, unusable = 0;
  TimeNs last = 0;
  for (std::size_t i = 0; i < frames; ++i) {
    const cv::Mat gray = cv::imread(r.images[i].second, cv::IMREAD_GRAYSCALE);
    const TimeNs t = r.images[i].first;
    Pose T_W_B;
    r.pose(t, &T_W_B);
    T_W_C[i] = T_W_B * r.T_B_C;
    Mat3 R = Mat3::Identity();
    if (i > 0 && a["rotation"] == "truth") R = T_W_C[i - 1].R().transpose() * T_W_C[i].R();
    if (i > 0 && (a["rotation"].empty() || a["rotation"] == "gyro"))
      R = r.gyroRotation(last, t, bias);
    R_C0_C.push_back(i == 0 ? R : Mat3(R_C0_C.back() * R));
    const std::clock_t before = std::clock();
    const vision::TrackedFrame frame = tracker.process(t, gray, R);
    cpu += 1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    last = t;
    pyramid += frame.ms_pyramid;
    flow += frame.ms_flow;
    detect += frame.ms_detect;
    unusable += !frame.usable;
    if (i > 0) {
      count += frame.continued;
      count_min = std::min(count_min, static_cast<double>(frame.continued));
      lost[0] += frame.lost_flow;
      lost[1] += frame.lost_backward;
      lost[2] += frame.lost_outlier;
      detected += frame.detected;
    }
    for (const vision::FeatureObservation& f : frame.features)
      tracks[f.id].push_back({i, f.px, f.bearing});
    if (!a["draw"].empty() && (i % 100 == 60)) {
      draw(gray, frame, tracks, i, a["draw"] + std::to_string(i) + ".png");
    }
  }
  const double n = static_cast<double>(frames);
  std::vector<double> lengths;
  for (const auto& [id, s] : tracks) lengths.push_back(static_cast<double>(s.size()));
  double mean = 0;
  for (double l : lengths) mean += l / static_cast<double>(lengths.size());
  std::printf("%zu images, CPU %.2f ms each (wall: pyramid %.2f flow %.2f detect %.2f)\n", frames,
              cpu / n, pyramid / n, flow / n, detect / n);
  std::printf(
      "continued %.1f (min %.0f), per image: lost flow %.2f backward %.2f outlier %.2f, new "
      "%.2f, unusable images %ld\n",
      count / (n - 1), count_min, static_cast<double>(lost[0]) / n,
      static_cast<double>(lost[1]) / n, static_cast<double>(lost[2]) / n,
      static_cast<double>(detected) / n, unusable);
  std::printf("track length: %zu tracks, mean %.1f, median %.0f, 75%% %.0f, 90%% %.0f images\n",
              lengths.size(), mean, quantile(lengths, 0.5), quantile(lengths, 0.75),
              quantile(lengths, 0.9));
  reportEpipolar(tracks, frames, 10, R_C0_C, *camera);
  reportEpipolar(tracks, frames, 25, R_C0_C, *camera);
  if (!r.truth.empty()) reportAccuracy(tracks, T_W_C, *camera);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "track_images: " << e.what() << "\n";
    return 2;
  }
}
