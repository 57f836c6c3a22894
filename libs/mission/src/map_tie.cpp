#include "vir/mission/map_tie.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "graph_edges.h"
#include "two_maps.h"
#include "vir/camera/camera_model.h"
#include "vir/places/describer.h"

namespace vir::mission {
namespace {

using Vec4 = Eigen::Vector4d;  // yaw, x, y, z
using Mat4 = Eigen::Matrix4d;

constexpr int kIterations = 5;

/// A keyframe of B in A's world, as its image has it.
struct Sighting {
  Vec3 p_A = Vec3::Zero(), p_B = Vec3::Zero();
  double turn_rad = 0;
  Mat4 covariance = Mat4::Identity();  ///< of (p_A, turn)
  TimeNs t = 0;                        ///< when both had been there
  std::size_t place = 0;
  double weight = 1;  ///< one over the number of those of its place
};

std::vector<Sighting> sightingsOf(const TwoMaps& both, const MissionMap& B,
                                  const LoopOptions& options) {
  std::map<std::uint64_t, const PlaceKeyframe*> of_B;
  for (const auto& k : B.keyframes) of_B[both.idOf(*k)] = k.get();
  std::vector<Sighting> out;
  for (const JudgedLoop& l : both.graph().loops()) {
    if (l.state != LoopState::accepted) continue;
    const auto older = both.finder().index().find(l.loop.older);
    const auto newer = of_B.find(l.loop.newer);
    if (!older || older->segment >= 0 || newer == of_B.end()) continue;
    const PlaceKeyframe& k = *newer->second;
    const LevelLoop level = levelLoop(l.loop, older->T_W_B, k.T_W_B, options.graph);
    Sighting s;
    s.p_A = older->T_W_B.p + level.motion_W;
    s.p_B = k.T_W_B.p;
    s.turn_rad = level.turn_rad;
    s.covariance = level.covariance;
    s.t = std::max(older->t, k.t);
    out.push_back(s);
  }
  return out;
}

/// Those nearer to one another than `apart_m` are of one place. How many places there are.
int groupByPlace(double apart_m, std::vector<Sighting>* sightings) {
  std::vector<Vec3> first;
  std::vector<int> count;
  for (Sighting& s : *sightings) {
    s.place = first.size();
    for (std::size_t i = 0; i < first.size(); ++i) {
      if ((first[i] - s.p_B).norm() < apart_m) {
        s.place = i;
        break;
      }
    }
    if (s.place == first.size()) {
      first.push_back(s.p_B);
      count.push_back(0);
    }
    ++count[s.place];
  }
  for (Sighting& s : *sightings) s.weight = 1.0 / count[s.place];
  return static_cast<int>(first.size());
}

/// Weighted squares that are left at `x`, and the normal equations there.
double linearise(const std::vector<Sighting>& sightings, const Vec4& x, Mat4* H, Vec4* g) {
  H->setZero();
  g->setZero();
  const Mat3 R = rotZ(x[0]);
  double sum = 0;
  for (const Sighting& s : sightings) {
    const Vec3 rotated = R * s.p_B;
    Vec4 e;
    e << s.p_A - rotated - x.tail<3>(), std::remainder(s.turn_rad - x[0], 2 * M_PI);
    Mat4 J = Mat4::Zero();
    J.topLeftCorner<3, 1>() = Vec3::UnitZ().cross(rotated);
    J.topRightCorner<3, 3>().setIdentity();
    J(3, 0) = 1;
    const auto solver = s.covariance.ldlt();
    sum += s.weight * e.dot(solver.solve(e));
    *H += s.weight * J.transpose() * solver.solve(J);
    *g += s.weight * J.transpose() * solver.solve(e);
  }
  return sum;
}

void fit(std::vector<Sighting>* sightings, double apart_m, SharedPlaces* out) {
  if (sightings->empty()) return;
  const int places = groupByPlace(apart_m, sightings);
  const Sighting& first = sightings->front();
  Vec4 x;
  x << first.turn_rad, first.p_A - rotZ(first.turn_rad) * first.p_B;
  Mat4 H;
  Vec4 g;
  for (int i = 0; i < kIterations; ++i) {
    linearise(*sightings, x, &H, &g);
    x += H.ldlt().solve(g);
  }
  const double left = linearise(*sightings, x, &H, &g);
  if (!x.allFinite() || !H.allFinite()) return;
  const double freedom = 4.0 * (places - 1);
  const double factor = freedom > 0 ? std::max(1.0, left / freedom) : 1.0;
  const Mat4 C = H.inverse();
  out->T_A_B = {std::remainder(x[0], 2 * M_PI), x.tail<3>()};
  out->covariance = 0.5 * factor * (C + C.transpose());
  out->places = places;
  out->images = static_cast<int>(sightings->size());
  out->since = out->until = first.t;
  for (const Sighting& s : *sightings) {
    out->centre_B += s.weight / places * s.p_B;
    out->since = std::min(out->since, s.t);
    out->until = std::max(out->until, s.t);
  }
}

}  // namespace

MapTie tie(const MissionMap& A, const MissionMap& B, const ImageOfKeyframe& image_of,
           const LoopOptions& options) {
  options.validate();
  TwoMaps both(A, B, options);
  places::Describer describer(options.describer, camera::makeCamera(B.calibration.camera));
  MapTie out;
  Image image;
  const auto look_for = [&](const PlaceKeyframe& k) {
    TwoMaps::Look how;
    const std::optional<Image> found = image_of(k);
    how.look = found.has_value();
    ++(how.look ? out.looked : out.imageless);
    if (!how.look) return how;
    image = *found;
    const Quat q_W_C = (k.T_W_B * k.T_B_C).q;
    how.compare = [&, q_W_C](const std::vector<places::ExpectedPoint>& expected) {
      return describer.compare(image, q_W_C, expected);
    };
    return how;
  };
  both.lookForAll(look_for, true);
  out.loops = both.graph().counts();
  std::vector<Sighting> sightings = sightingsOf(both, B, options);
  fit(&sightings, options.graph.opinion_m, &out.shared);
  return out;
}

}  // namespace vir::mission
