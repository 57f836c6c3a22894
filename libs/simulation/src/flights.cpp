#include "vir/simulation/flights.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "flight_shapes.h"
#include "vir/core/angles.h"
#include "vir/core/random.h"

namespace vir::simulation {
namespace {

constexpr TimeNs kBegin = 1000000000;
/// Distance of the control points that round the corners.
constexpr double kCoarse_s = 1.0;
constexpr double kFine_s = 0.05;
constexpr double kGravity = 9.81;

/// Sines of unit variance in sum, zero at time 0.
class Sway {
 public:
  Sway(Random* random, double low_hz, double high_hz) {
    for (Term& t : terms_) {
      t.omega = 2 * kPi * random->uniform(low_hz, high_hz);
      t.phase = random->uniform(0, 2 * kPi);
    }
  }
  double at(double t_s) const {
    double sum = 0;
    for (const Term& t : terms_) sum += std::sin(t.omega * t_s + t.phase);
    return sum * std::sqrt(2.0 / kTerms);
  }

 private:
  static constexpr int kTerms = 3;
  struct Term {
    double omega = 0, phase = 0;
  };
  Term terms_[kTerms];
};

/// 0 while standing, 1 in between, smooth.
double ramp(double t, double duration, double rest) {
  const double s = std::clamp(std::min(t - rest, duration - rest - t) / 2.0, 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

/// A stretch of rest along the way [s].
struct Stop {
  double from = 0, to = 0;
};

/// Walks a polyline at constant speed, standing still now and then.
struct Walk {
  std::vector<Vec3> p;             // every kCoarse_s
  std::vector<double> yaw;         // of the line walked on, continuous
  std::vector<std::size_t> stops;  // where in p they begin
};

/// Points of a stop: the spline rests where four in a row are the same.
std::size_t pointsOfStop(const FlightOptions& o) {
  return static_cast<std::size_t>(std::ceil(o.stop_s / kCoarse_s)) + 3;
}

Walk walk(const std::vector<Vec3>& points, const FlightOptions& o) {
  Walk w;
  const double step = o.speed_mps * kCoarse_s;
  double behind = 0, yaw = 0, to_stop = o.stop_every_m;
  bool first = true;
  const auto put = [&](const Vec3& p) {
    w.p.push_back(p);
    w.yaw.push_back(yaw);
    to_stop -= step;
    if (o.stop_every_m <= 0 || to_stop > 0) return;
    to_stop = o.stop_every_m;
    w.stops.push_back(w.p.size() - 1);
    w.p.insert(w.p.end(), pointsOfStop(o) - 1, p);
    w.yaw.insert(w.yaw.end(), pointsOfStop(o) - 1, yaw);
  };
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const Vec3 d = points[k + 1] - points[k];
    const double n = d.norm();
    if (n < 1e-9) continue;
    // Straight up or down the heading stays.
    const double heading = d.head<2>().norm() < 1e-6 ? yaw : std::atan2(d.y(), d.x());
    yaw = first ? heading : yaw + std::remainder(heading - yaw, 2 * kPi);
    if (first) put(points[k]);
    first = false;
    for (double s = step - behind; s <= n; s += step) put(points[k] + d * (s / n));
    behind = std::fmod(behind + n, step);
  }
  if (first) {
    yaw = o.start_heading_deg * kPi / 180;
    put(points.front());
  }
  return w;
}

/// Extra points at an end that rests.
std::size_t pointsOfRest(double rest_s) {
  return static_cast<std::size_t>(std::ceil(rest_s / kCoarse_s)) + 2;
}

/// Stands at both ends. The three extra points make the spline start and end at rest.
template <typename T>
std::vector<T> restAtEnds(const std::vector<T>& in, double rest_s) {
  const std::size_t extra = pointsOfRest(rest_s);
  std::vector<T> out(extra, in.front());
  out.insert(out.end(), in.begin(), in.end());
  out.insert(out.end(), extra, in.back());
  return out;
}

/// When the stops of a walk are, in the time of the spline with rests at its ends.
std::vector<Stop> stopsOf(const Walk& w, const FlightOptions& o) {
  std::vector<Stop> out;
  for (const std::size_t k : w.stops) {
    const double from = kCoarse_s * static_cast<double>(k + pointsOfRest(o.rest_s));
    out.push_back({from, from + kCoarse_s * static_cast<double>(pointsOfStop(o) - 3)});
  }
  return out;
}

/// 0 at a stop, 1 from 2 s away from it on.
double awayFrom(const std::vector<Stop>& stops, double t) {
  double least = 1;
  for (const Stop& s : stops) {
    const double x = std::clamp(std::max(s.from - t, t - s.to) / 2.0, 0.0, 1.0);
    least = std::min(least, x * x * (3 - 2 * x));
  }
  return least;
}

std::vector<Vec3> placed(const std::vector<Vec3>& points, const FlightOptions& o) {
  if (o.start_m.size() != 3) throw std::invalid_argument("start_m must hold 3 numbers");
  const Mat3 R = rotZ(o.start_heading_deg * kPi / 180);
  const Vec3 start(o.start_m[0], o.start_m[1], o.start_m[2]);
  std::vector<Vec3> out;
  for (const Vec3& p : points) out.push_back(start + R * p);
  return out;
}

}  // namespace

Motion flyAlong(const std::vector<Vec3>& points, const FlightOptions& o) {
  if (points.empty()) throw std::invalid_argument("flyAlong: no points");
  if (!(o.speed_mps > 0)) throw std::invalid_argument("flyAlong: speed_mps must be positive");
  const Walk w = walk(placed(points, o), o);
  const std::vector<Stop> stops = stopsOf(w, o);
  std::vector<Vec3> heading;
  for (double yaw : w.yaw) heading.emplace_back(yaw, 0, 0);
  const VectorSpline path(kCoarse_s, restAtEnds(w.p, o.rest_s));
  const VectorSpline turn(kCoarse_s, restAtEnds(heading, o.rest_s));
  Random random(static_cast<std::uint64_t>(o.seed), 0);
  std::vector<Sway> sway;
  for (int k = 0; k < 3; ++k) sway.emplace_back(&random, 0.2, 1.0);
  for (int k = 0; k < 3; ++k) sway.emplace_back(&random, 0.3, 1.5);
  const double duration = path.duration();
  Trajectory poses;
  for (int k = 0; k * kFine_s <= duration; ++k) {
    const double t = k * kFine_s;
    const double r = ramp(t, duration, o.rest_s) * awayFrom(stops, t);
    const VectorSplinePoint p = path.at(t);
    const Vec3 shake(sway[0].at(t), sway[1].at(t), sway[2].at(t));
    const Vec3 tilt(sway[3].at(t), sway[4].at(t), sway[5].at(t));
    const double rise = o.height_m * std::sin(2 * kPi * t / 23.0);
    Pose T;
    T.p = p.value + r * (o.sway_m * shake + rise * Vec3::UnitZ());
    const Quat q_yaw(rotZ(turn.at(t).value.x()));
    const Vec3 thrust = q_yaw.conjugate() * (p.second + kGravity * Vec3::UnitZ());
    T.q = q_yaw * Quat::FromTwoVectors(Vec3::UnitZ(), thrust) *
          expQuat(r * o.sway_deg * kPi / 180 * tilt);
    poses.push_back({kBegin + fromSeconds(t), T});
  }
  return Motion(kBegin, kFine_s, poses);
}

std::vector<std::string> flightNames() {
  std::vector<std::string> names = shapeNames();
  names.push_back("standing");
  return names;
}

Motion flight(const std::string& name, const FlightOptions& o) {
  const std::vector<Vec3> points = shapePoints(name, o.length_m);
  if (!points.empty()) {
    FlightOptions used = o;
    if (name == "stop_and_go" && o.stop_every_m <= 0) used.stop_every_m = 8;
    return flyAlong(points, used);
  }
  if (name == "standing") {
    FlightOptions still = o;
    still.rest_s = std::max(2.0, o.length_m / o.speed_mps / 2);
    still.sway_m = still.sway_deg = still.height_m = 0;
    return flyAlong({Vec3::Zero()}, still);
  }
  std::string known;
  for (const std::string& n : flightNames()) known += (known.empty() ? "" : ", ") + n;
  throw std::invalid_argument("flight: '" + name + "' is unknown; known are " + known);
}

}  // namespace vir::simulation
