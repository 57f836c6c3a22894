/// Starts somewhere in a rendered warehouse that was mapped before, on another path and in other
/// light: places_relocalise [STARTS [SEED [SCALE [FLIGHT [ASIDE_M]]]]]. Also starts in another
/// hall.
#include <cstdio>
#include <cstdlib>

#include "rendered_places.h"
#include "vir/places/loop_finder.h"
#include "vir/rendering/make_scene.h"
#include "vir/simulation/flights.h"

using namespace vir;

namespace {

constexpr double kMapEvery_s = 0.5, kEvery_s = 0.2;
constexpr int kImages = 6;  // 1 s

struct Counts {
  int found = 0, wrong = 0, near = 0;
  std::vector<double> errors_m, errors_rad;
};

}  // namespace

int main(int argc, char** argv) {
  const int starts = argc > 1 ? std::atoi(argv[1]) : 100;
  const int seed = argc > 2 ? std::atoi(argv[2]) : 1;
  const double scale = argc > 3 ? std::atof(argv[3]) : 0.5;
  const std::string flight = argc > 4 ? argv[4] : "warehouse";
  const double aside = argc > 5 ? std::atof(argv[5]) : 0.3;
  simulation::FlightOptions fo;
  fo.seed = seed;
  const simulation::Motion first = simulation::flight(flight, fo);
  fo.seed = seed + 100;
  fo.start_m = {0.1, aside, 0.15};
  fo.height_m = 0.6;
  const simulation::Motion second = simulation::flight(flight, fo);
  std::vector<Vec3> path;
  for (const auto& s : first.sampled(4)) path.push_back(s.T_W_B.p);
  for (const auto& s : second.sampled(4)) path.push_back(s.T_W_B.p);
  const auto hall = [&](int which) {
    rendering::SceneOptions so;
    so.seed = which;
    so.boxes = 120;
    return std::make_shared<rendering::Scene>(rendering::makeScene(so, path, {}));
  };
  const CameraCalibration cc = vir_test::eurocCamera(scale);
  rendering::CameraSimulationOptions light, dim;
  light.seed = 1;
  dim.seed = 2;
  dim.exposure_jump = {0, 0.6};
  places::VerifyOptions vo;
  vo.focal_px = cc.fx;
  const auto here = hall(seed), elsewhere = hall(seed + 50);
  vir_test::PlaceMaker mapper(here, cc, light, seed), robot(here, cc, dim, seed),
      stranger(elsewhere, cc, dim, seed + 50);

  std::vector<std::shared_ptr<const PlaceKeyframe>> map;
  for (double s = 0.5; s < first.duration() - 0.5; s += kMapEvery_s) {
    const TimeNs t = first.begin() + fromSeconds(s);
    map.push_back(mapper.keyframe(map.size(), t, first.poseAt(t)));
  }
  Random random(static_cast<std::uint64_t>(seed), 5);
  const auto start = [&](vir_test::PlaceMaker* maker, Counts* c) {
    places::LoopFinder finder({}, {}, vo);
    for (const auto& k : map) finder.remember(k);
    const double s0 = random.uniform(1.5, second.duration() - 3);
    // A new run begins in a W of its own.
    const Pose T_V_W(Quat(rotZ(random.uniform(-3, 3))), Vec3(5, -3, 1));
    bool told = false;
    for (int k = 0; k < kImages && !told; ++k) {
      const TimeNs t = second.begin() + fromSeconds(s0 + kEvery_s * k);
      const Pose truth = second.poseAt(t);
      const auto kf = maker->keyframe(1000000 + static_cast<std::uint64_t>(k), t, truth);
      kf->T_W_B = T_V_W * truth;
      for (const Loop& l : finder.add(kf)) {
        if (l.newer != kf->id) continue;
        told = true;
        const Pose at = map[l.older]->T_W_B * l.T_older_newer;
        const double e = (at.p - truth.p).norm(), turn = at.q.angularDistance(truth.q);
        c->errors_m.push_back(e);
        c->errors_rad.push_back(turn);
        c->near += e < 0.05 && turn < 0.01745;
        c->wrong += e > 0.3 || turn > 0.1;
      }
    }
    c->found += told;
  };
  Counts same, other;
  for (int k = 0; k < starts; ++k) start(&robot, &same);
  for (int k = 0; k < starts; ++k) start(&stranger, &other);
  std::sort(same.errors_m.begin(), same.errors_m.end());
  std::sort(same.errors_rad.begin(), same.errors_rad.end());
  std::printf(
      "%zu keyframes in the map; of %d starts found %d, within 5 cm and 1 deg %d, wrong %d\n",
      map.size(), starts, same.found, same.near, same.wrong);
  if (!same.errors_m.empty()) {
    const std::size_t n = same.errors_m.size();
    std::printf("error median %.4f m %.4f rad, 95 %% %.4f m %.4f rad\n", same.errors_m[n / 2],
                same.errors_rad[n / 2], same.errors_m[n * 95 / 100], same.errors_rad[n * 95 / 100]);
  }
  std::printf("another hall: of %d starts found %d\n", starts, other.found);
  return 0;
}
