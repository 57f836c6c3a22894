/// How far from where a place was seen first it is found again, and how well its pose is then
/// known: places_revisit ROOM_SEEDS PLACES. Rendered rooms; each first view is looked for from
/// places a stated distance and turn away, under other light.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

#include "rendered_places.h"
#include "vir/places/verify_loop.h"
#include "vir/rendering/make_scene.h"

using namespace vir;

namespace {

double cpu() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Offset {
  const char* name;
  double ahead, aside, yaw, roll;
};
const Offset kOffsets[] = {
    {"same place", 0.02, 0.02, 0.01, 0.01},        {"0.3 m aside", 0.0, 0.3, 0.02, 0.03},
    {"0.5 m ahead", 0.5, 0.1, 0.02, 0.03},         {"1.0 m ahead", 1.0, 0.1, 0.02, 0.05},
    {"0.7 m aside, 10 deg", 0.0, 0.7, 0.17, 0.05}, {"25 deg", 0.1, 0.1, 0.44, 0.0},
    {"roll 15 deg", 0.1, 0.1, 0.05, 0.26}};

}  // namespace

int main(int argc, char** argv) {
  const int rooms = argc > 1 ? std::atoi(argv[1]) : 2, places = argc > 2 ? std::atoi(argv[2]) : 8;
  constexpr std::size_t kCount = sizeof kOffsets / sizeof kOffsets[0];
  struct Sum {
    int tried = 0, found = 0;
    double matches = 0, inliers = 0, share = 0, nees = 0, error = 0;
    std::vector<double> all_nees;
  } sums[kCount];
  double describe_s = 0, verify_s = 0;
  int described = 0, verified = 0;
  for (int room = 1; room <= rooms; ++room) {
    std::vector<Vec3> path;
    for (int k = 0; k < 40; ++k) path.push_back(Vec3(0.25 * k, 1.5 * std::sin(0.3 * k), 0));
    rendering::SceneOptions so;
    so.seed = room;
    const auto scene = std::make_shared<rendering::Scene>(rendering::makeScene(so, path, {}));
    rendering::CameraSimulationOptions first, second;
    second.seed = 7;
    second.exposure_jump = {0, 0.7};
    vir_test::PlaceMaker a(scene, vir_test::eurocCamera(), first, room);
    vir_test::PlaceMaker b(scene, vir_test::eurocCamera(), second, room);
    Random random(static_cast<std::uint64_t>(room), 1);
    for (int k = 0; k < places; ++k) {
      const Vec3 p = path[random.below(path.size())] + Vec3(0, 0, random.uniform(-0.3, 0.3));
      const double yaw = random.uniform(-3.1, 3.1), pitch = random.uniform(-0.1, 0.1);
      const Pose at = vir_test::bodyAt(p, yaw, pitch, random.uniform(-0.1, 0.1));
      std::vector<std::shared_ptr<const PlaceKeyframe>> older{a.keyframe(1, fromSeconds(1), at)};
      for (const double side : {-0.15, 0.15}) {
        older.push_back(
            a.keyframe(1, fromSeconds(1), at * Pose(Quat::Identity(), Vec3(0.05, side, 0))));
      }
      for (std::size_t o = 0; o < kCount; ++o) {
        const Offset& off = kOffsets[o];
        const Pose move(Quat(rotZ(off.yaw)) * expQuat(Vec3(off.roll, 0, 0)),
                        Vec3(off.ahead, off.aside, 0.05));
        const Pose there = at * move;
        if (scene->hidden(at.p, there.p)) continue;
        const auto& image = b.take(there);
        const double t0 = cpu();
        const auto newer = b.describe(image, 2, fromSeconds(100), there);
        const double t1 = cpu();
        const places::LoopVerdict v = places::verifyLoop(*newer, older);
        verify_s += cpu() - t1;
        describe_s += t1 - t0;
        ++described;
        ++verified;
        Sum& s = sums[o];
        ++s.tried;
        s.matches += v.matches;
        s.inliers += v.inliers;
        s.share += v.share;
        if (!v.loop) continue;
        ++s.found;
        const places::RelativePrior truth{move, Eigen::Matrix<double, 6, 6>::Zero()};
        const double nees = places::loopChi2(*v.loop, truth);
        s.nees += nees;
        s.all_nees.push_back(nees);
        s.error += (v.loop->T_older_newer.p - move.p).norm();
      }
    }
  }
  std::printf("%-22s %6s %6s %8s %8s %6s %6s %8s %9s\n", "offset", "tried", "found", "matches",
              "inliers", "share", "nees/6", "median/6", "error[m]");
  for (std::size_t o = 0; o < kCount; ++o) {
    Sum& s = sums[o];
    std::sort(s.all_nees.begin(), s.all_nees.end());
    const double f = s.found > 0 ? s.found : 1;
    std::printf("%-22s %6d %6d %8.1f %8.1f %6.2f %6.2f %8.2f %9.4f\n", kOffsets[o].name, s.tried,
                s.found, s.matches / s.tried, s.inliers / s.tried, s.share / s.tried,
                s.nees / f / 6, s.all_nees.empty() ? 0 : s.all_nees[s.all_nees.size() / 2] / 6,
                s.error / f);
  }
  std::printf("describe (and landmarks) %.2f ms, verify %.2f ms\n", 1000 * describe_s / described,
              1000 * verify_s / verified);
  return 0;
}
