/// What an image costs, stage by stage, the two halves of the estimator apart. See --help.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <numeric>

#include "recordings/companion.h"
#include "replay.h"
#include "vir/core/order_statistics.h"
#include "vir/core/settings.h"

using namespace vir;
using namespace vir::tool;

namespace {

const char* const kExamples =
    "replay_stages clip.rawlog --ini ini/euroc.ini\n"
    "replay_stages clip.rawlog --set Estimator.use_ranges=false --rounds 5\n\n"
    "CPU time per image of a recording, of images that become keyframes and of the others. The\n"
    "front end works on decoded images with the feedback of a run, then the back end on what the\n"
    "front end sent in it; of each image and stage the least of all rounds counts.\n";

struct Arguments {
  std::string rawlog, ini;
  std::vector<std::string> set;
  int rounds = 3;
};

/// In the order they are worked through; `other`: what is in no stage of its own.
const std::vector<std::vector<std::string>> kStages = {
    {"decoding"},
    {"front end", "pyramid", "flow", "detect", "other (front)"},
    {"back end", "initialise", "optimise", "marginalise", "other (back)"},
    {"front + back"}};

struct ImageCost {
  bool valid = false, keyframe = false;
  Stages ms;
};
/// By the image's stamp.
using Costs = std::map<TimeNs, ImageCost>;

void note(Stages* least, const Stages& round) {
  for (const auto& [stage, ms] : round) {
    const auto [at, first] = least->emplace(stage, ms);
    if (!first) at->second = std::min(at->second, ms);
  }
}

VirSettings settingsOf(const Arguments& a) {
  Settings settings = a.ini.empty() ? Settings() : Settings::fromFile(a.ini);
  for (const std::string& assignment : a.set) settings.set(assignment);
  const std::string beside = app::companionOf(a.rawlog);
  if (!beside.empty()) settings.mergeDefaults(Settings::fromFile(beside));
  settings.eraseKey("driver");  // it is this one
  VirSettings out;
  SettingsReader reader(settings);
  out.describe(reader);
  if (!beside.empty()) reader.ignoreUnknownFrom(beside);
  reader.finish();
  if (!out.otherCameraLabels().empty()) {
    throw std::invalid_argument("[Estimator] other_cameras = " + out.other_cameras +
                                ": the images of one camera are replayed; set it to none");
  }
  return out;
}

Costs measure(const Replay& replay, int rounds) {
  Costs costs;
  for (int round = 0; round < rounds; ++round) {
    replay.frontEnd([&](const estimator::Packet& p, double decode_ms) {
      if (p.kind != estimator::Packet::Kind::image) return;
      const vision::TrackedFrame& f = p.frame;
      note(&costs[p.stamp].ms, {{"decoding", decode_ms},
                                {"front end", p.ms},
                                {"pyramid", f.ms_pyramid},
                                {"flow", f.ms_flow},
                                {"detect", f.ms_detect},
                                {"other (front)", p.ms - f.ms_pyramid - f.ms_flow - f.ms_detect}});
    });
    replay.backEnd([&](const StateEstimate& s, double ms) {
      ImageCost& cost = costs[s.t_image];
      cost.valid = s.valid;
      cost.keyframe = s.keyframe;
      note(&cost.ms, {{"back end", ms},
                      {"initialise", s.ms.initialise},
                      {"optimise", s.ms.optimise},
                      {"marginalise", s.ms.marginalise},
                      {"other (back)", ms - s.ms.initialise - s.ms.optimise - s.ms.marginalise}});
    });
  }
  for (auto& [stamp, cost] : costs) {
    cost.ms["front + back"] = cost.ms["front end"] + cost.ms["back end"];
  }
  return costs;
}

/// Median, 95 % and mean of a stage over the keyframes or the others.
void printColumns(const Costs& costs, const std::string& stage, bool keyframes) {
  std::vector<double> ms;
  for (const auto& [stamp, cost] : costs) {
    const auto at = cost.ms.find(stage);
    if (cost.valid && cost.keyframe == keyframes && at != cost.ms.end()) ms.push_back(at->second);
  }
  std::sort(ms.begin(), ms.end());
  const double sum = std::accumulate(ms.begin(), ms.end(), 0.0);
  std::printf(" | %7.2f %7.2f %7.2f", quantileOfSorted(ms, 0.5), quantileOfSorted(ms, 0.95),
              ms.empty() ? 0 : sum / static_cast<double>(ms.size()));
}

void print(const Replayed& run, const Costs& costs, int rounds) {
  const auto states =
      std::count_if(costs.begin(), costs.end(), [](const auto& c) { return c.second.valid; });
  const auto keyframes = std::count_if(costs.begin(), costs.end(), [](const auto& c) {
    return c.second.valid && c.second.keyframe;
  });
  for (const auto& [label, count] : run.other_images) {
    std::printf("%ld images of %s are left out: one camera is replayed\n", count, label.c_str());
  }
  std::printf("%zu images, %td of them with a state, %td keyframes; least of %d rounds\n",
              costs.size(), states, keyframes, rounds);
  std::printf("%-16s | %-23s | %-23s\n", "CPU [ms]", "keyframes", "others");
  std::printf("%-16s | %7s %7s %7s | %7s %7s %7s\n", "", "median", "95 %", "mean", "median", "95 %",
              "mean");
  for (const auto& group : kStages) {
    for (const std::string& stage : group) {
      const std::string name = (stage == group.front() ? "" : "  ") + stage;
      std::printf("%-16s", name.c_str());
      printColumns(costs, stage, true);
      printColumns(costs, stage, false);
      std::printf("\n");
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(kExamples);
  Arguments a;
  app.add_option("rawlog", a.rawlog, "recording with images of one camera and an IMU")->required();
  app.add_option("--ini", a.ini,
                 "settings, as of `vir-slam run`; the ini beside the recording too");
  app.add_option("--set", a.set, "Section.key=value")->take_all();
  app.add_option("--rounds", a.rounds, "how often each half is measured")
      ->check(CLI::Range(1, 1000));
  try {
    app.parse(argc, argv);
    Replay replay(a.rawlog, settingsOf(a));
    const Replayed& run = replay.run();
    print(run, measure(replay, a.rounds), a.rounds);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const std::invalid_argument& e) {
    std::cerr << "replay_stages: " << e.what() << '\n';
    return 2;
  } catch (const SettingsError& e) {
    std::cerr << "replay_stages: " << e.what() << '\n';
    return 2;
  } catch (const std::exception& e) {
    std::cerr << "replay_stages: " << e.what() << '\n';
    return 1;
  }
  return 0;
}
