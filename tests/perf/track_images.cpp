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
#include <limits>
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

/// Of the values, how many are above `limit` [%].
double shareAbove(const std::vector<double>& values, double limit) {
  const auto n =
      std::count_if(values.begin(), values.end(), [limit](double v) { return v > limit; });
  return 100.0 * static_cast<double>(n) /
         static_cast<double>(std::max<std::size_t>(values.size(), 1));
}

double rootMean(double sum, long n) {
  return std::sqrt(sum / static_cast<double>(std::max(n, 1L)));
}

/// Residuals of tracks of a length, and how they change from image to image.
struct LengthBin {
  std::size_t low, high;
  double sum = 0, steps = 0;
  long n = 0, n_steps = 0;

  void add(const std::vector<Vec2>& r) {
    if (r.size() < low || r.size() >= high) return;
    for (const Vec2& e : r) sum += e.squaredNorm();
    for (std::size_t i = 1; i < r.size(); ++i) steps += (r[i] - r[i - 1]).squaredNorm();
    n += 2 * static_cast<long>(r.size());
    n_steps += 2 * static_cast<long>(r.size() - 1);
  }
};

struct Accuracy {
  std::vector<double> all, track_rms;
  std::vector<LengthBin> bins = {{4, 8}, {8, 16}, {16, 32}, {32, 64}, {64, std::size_t{1} << 30}};

  /// Of one track.
  void add(const std::vector<Vec2>& r) {
    double sum = 0;
    for (const Vec2& e : r) {
      sum += e.squaredNorm();
      all.push_back(std::abs(e.x()));
      all.push_back(std::abs(e.y()));
    }
    track_rms.push_back(rootMean(sum, 2 * static_cast<long>(r.size())));
    // Wrong tracks would hide the accuracy of good ones: counted in the tails instead.
    if (track_rms.back() > 2.0) return;
    for (LengthBin& b : bins) b.add(r);
  }
  /// Root mean square of those below `limit`.
  double rmsBelow(double limit) const {
    double sum = 0;
    long n = 0;
    for (const double e : all) {
      if (e >= limit) continue;
      sum += e * e;
      ++n;
    }
    return rootMean(sum, n);
  }
};

void reportAccuracy(const Tracks& tracks, const std::vector<Pose>& T_W_C,
                    const camera::CameraModel& cam) {
  Accuracy found;
  for (const auto& [id, s] : tracks) {
    if (s.size() < 4) continue;
    const auto r = residuals(s, T_W_C, cam);
    if (!r.empty()) found.add(r);
  }
  const std::vector<double>& all = found.all;
  std::printf(
      "residual per axis [px]: tracks %zu, rms %.3f, rms below 2 px %.3f, |r| 50%% %.3f 68%% "
      "%.3f 95%% %.3f 99%% %.3f; above 1 px %.2f %%, 2 px %.2f %%, 5 px %.2f %%; tracks with "
      "rms above 1 px %.2f %%\n",
      found.track_rms.size(), found.rmsBelow(std::numeric_limits<double>::infinity()),
      found.rmsBelow(2.0), quantile(all, 0.5), quantile(all, 0.68), quantile(all, 0.95),
      quantile(all, 0.99), shareAbove(all, 1.0), shareAbove(all, 2.0), shareAbove(all, 5.0),
      shareAbove(found.track_rms, 1.0));
  std::printf("by track length (rms px | rms step px):");
  for (const LengthBin& b : found.bins) {
    std::printf("  %zu+: %.3f | %.3f", b.low, rootMean(b.sum, b.n), rootMean(b.steps, b.n_steps));
  }
  std::printf("\n");
}

/// Distance from the epipolar line between images `gap` apart, with the relative pose fitted to the
/// tracks themselves: needs no ground truth, sees only one of two axes.
void reportEpipolar(const Tracks& tracks, std::size_t images, std::size_t gap,
                    const std::vector<Mat3>& R_C0_C, const camera::CameraModel& camera) {
  std::vector<double> all;
  for (std::size_t i = 0; i + gap < images; i += 5) {
    std::vector<vision::BearingPair> pairs;
    double parallax = 0;
    const Mat3 R = R_C0_C[i].transpose() * R_C0_C[i + gap];
    for (const auto& [id, s] : tracks) {
      if (s.front().image > i || s.back().image < i + gap) continue;
      vision::BearingPair p;
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
    const vision::MotionVerdict v = vision::filterByMotion(pairs, R, 0.02, 2.0);
    if (v.direction.isZero()) continue;
    const Mat3 R_fit = R * expSO3(v.rotation_correction);
    for (const vision::BearingPair& p : pairs) {
      const Vec3 m = R_fit.transpose() * v.direction.cross(p.b0);
      const Vec2 g = (p.J1 * p.J1.transpose()).inverse() * p.J1 * m;
      all.push_back(std::abs(m.dot(p.b1)) / g.norm());
    }
  }
  std::printf(
      "epipolar distance over %zu images [px]: n %zu, 50%% %.3f 68%% %.3f 95%% %.3f; above 1 px "
      "%.2f %%, 2 px "
      "%.2f %%\n",
      gap, all.size(), quantile(all, 0.5), quantile(all, 0.68), quantile(all, 0.95),
      shareAbove(all, 1.0), shareAbove(all, 2.0));
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

Arguments readArguments(int argc, char** argv) {
  if (argc < 2) throw std::runtime_error("usage: track_images MAV0 [KEY=VALUE]...");
  Arguments a;
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    const std::size_t eq = word.find('=');
    if (eq == std::string::npos) throw std::runtime_error("not KEY=VALUE: " + word);
    a[word.substr(0, eq)] = word.substr(eq + 1);
  }
  return a;
}

/// Empty if it is not given.
std::string valueOf(const Arguments& a, const std::string& key) {
  const auto it = a.find(key);
  return it == a.end() ? std::string() : it->second;
}

/// What the tracker says of its images, added up.
struct Totals {
  double cpu_ms = 0, pyramid_ms = 0, flow_ms = 0, detect_ms = 0;
  double continued = 0, fewest_continued = 1e9;
  long lost_flow = 0, lost_backward = 0, lost_outlier = 0, detected = 0, unusable = 0;

  void add(const vision::TrackedFrame& frame, bool first) {
    pyramid_ms += frame.ms_pyramid;
    flow_ms += frame.ms_flow;
    detect_ms += frame.ms_detect;
    unusable += !frame.usable;
    if (first) return;
    continued += frame.continued;
    fewest_continued = std::min(fewest_continued, static_cast<double>(frame.continued));
    lost_flow += frame.lost_flow;
    lost_backward += frame.lost_backward;
    lost_outlier += frame.lost_outlier;
    detected += frame.detected;
  }
};

struct TrackingRun {
  Tracks tracks;
  std::vector<Pose> T_W_C;   ///< true, of each image
  std::vector<Mat3> R_C0_C;  ///< as the tracker was told
  Totals totals;
};

/// What the tracker is told of the turn from the image before to image `i`, from `source`.
Mat3 rotationTo(std::size_t i, const Recording& r, const std::vector<Pose>& T_W_C,
                const std::string& source, const Vec3& bias) {
  if (i > 0 && source == "truth") return T_W_C[i - 1].R().transpose() * T_W_C[i].R();
  if (i > 0 && (source.empty() || source == "gyro")) {
    return r.gyroRotation(r.images[i - 1].first, r.images[i].first, bias);
  }
  return Mat3::Identity();
}

TrackingRun follow(const Recording& r, const Arguments& a, vision::FeatureTracker* tracker) {
  const std::string limit = valueOf(a, "frames"), pictures = valueOf(a, "draw"),
                    source = valueOf(a, "rotation"), bias_text = valueOf(a, "bias");
  Vec3 bias = Vec3::Zero();
  if (!bias_text.empty()) bias = Eigen::Map<const Vec3>(numbers(bias_text).data());
  const std::size_t frames =
      std::min(r.images.size(), limit.empty() ? r.images.size() : std::stoul(limit));
  TrackingRun out;
  out.T_W_C.resize(frames);
  for (std::size_t i = 0; i < frames; ++i) {
    const auto& [t, file] = r.images[i];
    const cv::Mat gray = cv::imread(file, cv::IMREAD_GRAYSCALE);
    Pose T_W_B;
    r.pose(t, &T_W_B);
    out.T_W_C[i] = T_W_B * r.T_B_C;
    const Mat3 R = rotationTo(i, r, out.T_W_C, source, bias);
    out.R_C0_C.push_back(i == 0 ? R : Mat3(out.R_C0_C.back() * R));
    const std::clock_t before = std::clock();
    const vision::TrackedFrame frame = tracker->process(t, gray, R);
    out.totals.cpu_ms += 1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    out.totals.add(frame, i == 0);
    for (const vision::FeatureObservation& f : frame.features) {
      out.tracks[f.id].push_back({i, f.px, f.bearing});
    }
    if (!pictures.empty() && i % 100 == 60) {
      draw(gray, frame, out.tracks, i, pictures + std::to_string(i) + ".png");
    }
  }
  return out;
}

void reportTracking(const TrackingRun& found) {
  const Totals& s = found.totals;
  const double n = static_cast<double>(found.T_W_C.size());
  std::printf("%zu images, CPU %.2f ms each (wall: pyramid %.2f flow %.2f detect %.2f)\n",
              found.T_W_C.size(), s.cpu_ms / n, s.pyramid_ms / n, s.flow_ms / n, s.detect_ms / n);
  std::printf(
      "continued %.1f (min %.0f), per image: lost flow %.2f backward %.2f outlier %.2f, new "
      "%.2f, unusable images %ld\n",
      s.continued / (n - 1), s.fewest_continued, static_cast<double>(s.lost_flow) / n,
      static_cast<double>(s.lost_backward) / n, static_cast<double>(s.lost_outlier) / n,
      static_cast<double>(s.detected) / n, s.unusable);
  std::vector<double> lengths;
  for (const auto& [id, sights] : found.tracks) {
    lengths.push_back(static_cast<double>(sights.size()));
  }
  double mean = 0;
  for (double l : lengths) mean += l / static_cast<double>(lengths.size());
  std::printf("track length: %zu tracks, mean %.1f, median %.0f, 75%% %.0f, 90%% %.0f images\n",
              lengths.size(), mean, quantile(lengths, 0.5), quantile(lengths, 0.75),
              quantile(lengths, 0.9));
}

int run(int argc, char** argv) {
  const Arguments a = readArguments(argc, argv);
  cv::setNumThreads(1);
  const Recording r = readRecording(argv[1], valueOf(a, "truth"));
  const auto camera = camera::makeCamera(r.calibration);
  vision::TrackerOptions options;
  ArgumentReader reader(a);
  describe(reader, options);
  vision::FeatureTracker tracker(options, camera);
  const TrackingRun found = follow(r, a, &tracker);
  reportTracking(found);
  for (const std::size_t gap : {std::size_t{10}, std::size_t{25}}) {
    reportEpipolar(found.tracks, found.T_W_C.size(), gap, found.R_C0_C, *camera);
  }
  if (!r.truth.empty()) reportAccuracy(found.tracks, found.T_W_C, *camera);
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
