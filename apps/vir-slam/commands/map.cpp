/// vir-slam map info MAP | merge MAP MAP... --out MAP: maps that runs have left.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "commands/commands.h"
#include "output/overwrite.h"
#include "setup/given_maps.h"
#include "vir/mission/map_merge.h"

namespace vir::app {
namespace {

constexpr const char* kHelp =
    R"(Maps of earlier runs (run --save-map, --map)
Examples:
  vir-slam map info hall.virmap
  vir-slam map merge hall.virmap yard.virmap --out site.virmap
Exit code 1 where maps have no place in common.)";

void info(const std::string& file) {
  const mission::MissionMap map = readMap(file);
  std::size_t points = 0;
  std::vector<Landmark> landmarks;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  double way = 0;
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const PlaceKeyframe& k = *map.keyframes[i];
    points += k.points.size();
    mission::addMapPoints(k, k.T_W_B, mission::LoopOptions().max_landmark_sigma, &landmarks);
    const Vec3& p = k.T_W_B.p;
    low = i == 0 ? p : Vec3(low.cwiseMin(p));
    high = i == 0 ? p : Vec3(high.cwiseMax(p));
    if (i > 0 && map.keyframes[i - 1]->segment == k.segment) {
      way += (p - map.keyframes[i - 1]->T_W_B.p).norm();
    }
  }
  const CameraCalibration& c = map.calibration.camera;
  std::printf("keyframes  %zu, %zu corners\n", map.keyframes.size(), points);
  std::printf("path       %.1f m, within %.1f x %.1f x %.1f m\n", way, high.x() - low.x(),
              high.y() - low.y(), high.z() - low.z());
  std::printf("landmarks  %zu\n", landmarks.size());
  std::printf("camera     %d x %d px, fx %.2f fy %.2f cx %.2f cy %.2f\n", c.width, c.height, c.fx,
              c.fy, c.cx, c.cy);
  for (const Anchor& a : map.anchors) {
    std::printf("anchor     %llu at %.3f %.3f %.3f m, sigma %.3f %.3f %.3f m\n",
                static_cast<unsigned long long>(a.id), a.p_W.x(), a.p_W.y(), a.p_W.z(),
                std::sqrt(a.covariance(0, 0)), std::sqrt(a.covariance(1, 1)),
                std::sqrt(a.covariance(2, 2)));
  }
  std::printf("size       %.2f MB\n", static_cast<double>(std::filesystem::file_size(file)) / 1e6);
}

void told(const std::string& file, const mission::MergedMaps& merged) {
  if (merged.loops.accepted > 0) {
    std::printf("%s: joined by %ld places seen in both\n", file.c_str(), merged.loops.accepted);
  }
  if (merged.known > 0) {
    std::printf(
        "%s: %ld of its keyframes are in the maps before, of the same images, and are not taken "
        "again\n",
        file.c_str(), merged.known);
  }
}

void mergeMaps(const std::vector<std::string>& files, const std::string& out) {
  if (files.size() < 2) throw UsageError("map merge: give at least two maps");
  mission::MissionMap map = readMap(files.front());
  for (std::size_t i = 1; i < files.size(); ++i) {
    const mission::MissionMap next = readMap(files[i]);
    try {
      const mission::MergedMaps merged = mission::merge(map, next, {});
      map = merged.map;
      told(files[i], merged);
    } catch (const std::runtime_error& e) {
      throw std::runtime_error(files[i] + ": " + e.what());
    }
  }
  mission::saveMap(map, out);
  std::printf("wrote %s: %zu keyframes\n", out.c_str(), map.keyframes.size());
}

}  // namespace

void addMap(CLI::App& app, Common& common) {
  CLI::App* command = app.add_subcommand("map", kHelp);
  command->require_subcommand(1);
  const auto file = std::make_shared<std::string>();
  CLI::App* show = command->add_subcommand("info", "What a map holds");
  show->add_option("MAP", *file, "Map file")->required();
  show->callback([file] { info(*file); });

  const auto files = std::make_shared<std::vector<std::string>>();
  const auto out = std::make_shared<std::string>();
  CLI::App* merge =
      command->add_subcommand("merge", "Maps of the same place in one, in the frame of the first");
  merge->add_option("MAP", *files, "Map files")->required();
  merge->add_option("--out", *out, "Map to write")->required();
  merge->callback([files, out, &common] {
    requireMapPlace(*out);
    refuseToOverwrite(*out, Written::map, common);
    mergeMaps(*files, *out);
  });
}

}  // namespace vir::app
