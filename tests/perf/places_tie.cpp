/// Two robots among aisles of identical shelves: what do their images say of their worlds?
/// places_tie UNIQUE_PER_BAY SEEDS [SCALE]: A maps the first two aisles; B has been in the last two
/// (every place that is found is a wrong one), or in the last three.
#include <cstdio>
#include <cstdlib>

#include "lookalike_place.h"
#include "vir/mission/map_tie.h"

using namespace vir;

namespace {

struct Robot {
  mission::MissionMap map;
  std::vector<rendering::GrayImage> images;
};

/// In a world of its own, of the part of the way between two rows [m].
Robot visit(const vir_test::AisleOptions& o, vir_test::PlaceMaker* maker, const Calibration& c,
            const LevelTransform& T_W, double from_y, double to_y) {
  Robot out;
  out.map.calibration = c;
  for (const Pose& T : vir_test::rounds(o, 1, 0.3)) {
    if (T.p.y() < from_y || T.p.y() > to_y) continue;
    const std::size_t id = out.images.size();
    const TimeNs t = fromSeconds(0.4 * static_cast<double>(id));
    out.images.push_back(maker->take(T, std::fmod(toSeconds(t), 1000)));
    auto k = maker->describe(out.images.back(), id, t, T);
    k->T_W_B = T_W.pose() * T;
    out.map.keyframes.push_back(k);
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  vir_test::AisleOptions o;
  o.unique_per_bay = argc > 1 ? std::atoi(argv[1]) : 0;
  const int seeds = argc > 2 ? std::atoi(argv[2]) : 1;
  const double scale = argc > 3 ? std::atof(argv[3]) : 1;
  const double row = o.aisle_m + o.shelf_m;
  const LevelTransform T_B{1.2, Vec3(-5, 9, 2)};
  Calibration c;
  c.camera = vir_test::eurocCamera(scale);
  c.T_B_C = vir_test::cameraInBody();
  mission::LoopOptions options;
  for (o.seed = 1; o.seed <= seeds; ++o.seed) {
    rendering::CameraSimulationOptions co;
    co.seed = o.seed;
    vir_test::PlaceMaker maker(vir_test::aisles(o), c.camera, co, o.seed);
    const Robot a = visit(o, &maker, c, {}, -1, 1.5 * row - 0.1);
    for (const double from : {1.5 * row, 0.5 * row}) {
      const Robot b = visit(o, &maker, c, T_B, from, 100);
      const auto image_of = [&](const PlaceKeyframe& k) {
        const rendering::GrayImage& image = b.images[k.id];
        Image view;
        view.width = image.width;
        view.height = image.height;
        view.pixels = image.pixels.data();
        return std::optional<Image>(view);
      };
      const mission::MapTie tie = mission::tie(a.map, b.map, image_of, options);
      const Vec3 at = tie.shared.centre_B;
      const double off = (tie.shared.T_A_B * at - T_B.inverse() * at).norm();
      std::printf("seed %d, %s: %d places by %d of %ld images, off by %.3f m (sigma of yaw %.4f)\n",
                  o.seed, from > row ? "apart  " : "overlap", tie.shared.places, tie.shared.images,
                  tie.looked, tie.shared.places > 0 ? off : 0.0,
                  std::sqrt(tie.shared.covariance(0, 0)));
    }
  }
  return 0;
}
