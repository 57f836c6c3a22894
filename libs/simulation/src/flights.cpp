#include "vir/simulation/flights.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "vir/core/random.h"

namespace vir {
namespace {

constexpr TimeNs kBegin = 1000000000;
/// Distance of the control points that round the corners.
constexpr double kCoarse_s = 1.0;
constexpr double kFine_s = 0.05;
constexpr double kGravity = 9.81;
constexpr double kPi = 3.14159265358979323846;

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

std::vector<Vec3> line(const std::vector<Vec3>& corners, double length) {
  std::vector<Vec3> out{corners.front()};
  for (std::size_t k = 1; length > 0; ++k) {
    const Vec3& to = corners[k % corners.size()];
    const Vec3 step = to - out.back();
    const double n = step.norm();
    out.push_back(n <= length ? to : Vec3(out.back() + step * (length / n)));
    length -= n;
  }
  return out;
}

std::vector<Vec3> eight(double length) {
  std::vector<Vec3> out{Vec3::Zero()};
  for (int k = 1; length > 0; ++k) {
    const double a = 2 * kPi * k / 200;
    out.emplace_back(6 * std::sin(a), 3 * std::sin(2 * a), 0);
    length -= (out.back() - out[out.size() - 2]).norm();
  }
  return out;
}

/// Walks a polyline at constant speed.
struct Walk {
  std::vector<Vec3> p;      // every kCoarse_s
  std::vector<double> yaw;  // of the line walked on, continuous
};

Walk walk(const std::vector<Vec3>& points, const FlightOptions& o) {
  Walk w;
  const double step = o.speed_mps * kCoarse_s;
  double behind = 0, yaw = 0;
  bool first = true;
  const auto put = [&](const Vec3& p) {
    w.p.push_back(p);
    w.yaw.push_back(yaw);
  };
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const Vec3 d = points[k + 1] - points[k];
    const double n = d.norm();
    if (n < 1e-9) continue;
    const double heading = std::atan2(d.y(), d.x());
    yaw = first ? heading : yaw + std::remainder(heading - yaw, 2 * kPi);
    if (first) put(points[k]);
    first = false;
    for (double s = step - behind; s <= n; s += step) put(points[k] + d * (s / n));
    behind = std::fmod(behind + n, step);
  }
  if (first) put(points.front());
  return w;
}

/// Stands at both ends. The three extra points make the spline start and end at rest.
template <typename T>
std::vector<T> restAtEnds(const std::vector<T>& in, double rest_s) {
  const auto extra = static_cast<std::size_t>(std::ceil(rest_s / kCoarse_s)) + 2;
  std::vector<T> out(extra, in.front());
  out.insert(out.end(), in.begin(), in.end());
  out.insert(out.end(), extra, in.back());
  return out;
}

}  // namespace

Motion flyAlong(const std::vector<Vec3>& points, const FlightOptions& o) {
  if (points.empty()) throw std::invalid_argument("flyAlong: no points");
  if (!(o.speed_mps > 0)) throw std::invalid_argument("flyAlong: speed_mps must be positive");
  const Walk w = walk(points, o);
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
    const double r = ramp(t, duration, o.rest_s);
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

std::vector<std::string> flightNames() { return {"eight", "corridor", "route", "standing"}; }

Motion flight(const std::string& name, const FlightOptions& o) {
  const double L = o.length_m;
  if (name == "eight") return flyAlong(eight(L), o);
  if (name == "corridor") {
    const double half = std::max(1.0, L / 2 - 1.5);
    return flyAlong(line({{0, 0, 0}, {half, 0, 0}, {half, 3, 0}, {0, 3, 0}}, L), o);
  }
  if (name == "route") {
    return flyAlong(line({{0, 0, 0},
                          {8, 0, 0},
                          {8, 5, 0.5},
                          {11, 5, 1},
                          {11, 0, 0.5},
                          {20, 0, 0},
                          {20, 14, 1},
                          {13, 14, 1.5},
                          {13, 9, 1.5},
                          {5, 9, 0.5},
                          {5, 14, 0},
                          {0, 14, 0}},
                         L),
                    o);
  }
  if (name == "standing") {
    FlightOptions still = o;
    still.rest_s = std::max(2.0, L / o.speed_mps / 2);
    still.sway_m = still.sway_deg = still.height_m = 0;
    return flyAlong({Vec3::Zero()}, still);
  }
  throw std::invalid_argument("flight: '" + name +
                              "' is unknown; known are eight, corridor, route, standing");
}

}  // namespace vir
