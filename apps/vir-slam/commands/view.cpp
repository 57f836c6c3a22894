/// vir-slam view RUN | FILE.rawlog | INI: a run in a window or as a film.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "commands/commands.h"
#include "live/run_player.h"
#include "output/console.h"
#include "output/overwrite.h"
#include "setup/calibration_option.h"
#include "setup/prepared_run.h"
#include "setup/run_source.h"
#include "vir/core/scratch_folder.h"
#include "vir/rawlog/mrpt_error.h"
#include "vir/runs/offline_run.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

constexpr const char* kHelp =
    R"(Look at a run: path, robot, anchors, map points, and the image with its tracks
Examples:
  vir-slam view results/flight                       a run again, in a window
  vir-slam view flight.rawlog --speed 4
  vir-slam view results/flight --video flight.mp4    as a film; needs no display
  vir-slam view results/flight --video part.mp4 --start-s 20 --end-s 50
Keys in the window: blank pause, . one image, + and - speed, j 10 s ahead, q end. The estimator runs
again with the same settings, so what is seen is what was computed; nothing is written but the film.)";

struct Arguments {
  RunSource source;
  RunArguments run;
  RunPlayer::Options player;
  std::string video;
};

/// A folder of results has the settings of its run.
void findSource(Common& common, Arguments* a) {
  const fs::path used = fs::path(a->source.what) / "used.ini";
  if (fs::is_regular_file(used)) {
    a->run.ini = used.string();
    return;
  }
  resolveSource(a->source, common, &a->run);
}

std::unique_ptr<LiveView> openView(const Arguments& a) {
  if (!a.video.empty()) return openVideoView(a.video, a.player.speed);
  try {
    return openLiveView();
  } catch (const std::exception& e) {
    throw std::runtime_error("no window: " + rawlog::shortReason(e) +
                             "; give --video FILE.mp4, or open the report.html of a run");
  }
}

void view(Arguments a, Common& common) {
  const ScratchFolder scratch("vir-slam-view");
  a.run.out = (scratch / "run").string();
  findSource(common, &a);
  PreparedRun prepared = prepareRun(a.run, common);
  const auto view = openView(a);
  RunPlayer::Options playing = a.player;
  if (!a.video.empty()) playing.speed = 0;  // the film has its own pace
  RunPlayer player(view.get(), playing);
  if (a.video.empty()) std::fprintf(stderr, "%s\n", RunPlayer::keys());

  ProgressBar bar;
  runs::OfflineRunHooks hooks;
  hooks.log = [&](LogLevel level, const std::string& text) {
    if (level != LogLevel::warning && level != LogLevel::error) return;
    // That the run was not played to its end is what was asked for.
    if (player.over() && !interrupted()) return;
    bar.clear();
    std::fprintf(stderr, "%s: %s\n", levelName(level), text.c_str());
  };
  hooks.progress = [&](double part) { bar.show(part); };
  hooks.stop = [&] { return interrupted() || player.over(); };
  hooks.prepare = [&](mrpt::obs::CObservation* o) { prepared.calibration.apply(o); };
  hooks.observers.push_back(&player);
  *prepared.log = hooks.log;
  const runs::OfflineRunOptions options =
      offlineOptions(prepared.options, prepared.inputs, hooks.log);
  const results::RunSummary summary =
      runs::runOffline(*prepared.estimator, options, results::ResultsFolder(a.run.out), hooks);
  bar.clear();
  if (!a.video.empty() && fs::exists(a.video)) std::printf("wrote %s\n", a.video.c_str());
  if (summary.poses == 0 || !summary.error.empty()) common.exit_code = kRunFailed;
}

}  // namespace

void addView(CLI::App& app, Common& common) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("view", kHelp);
  command->add_option("WHAT", a->source.what, "Folder of a run, rawlog, or ini")->required();
  command->add_option("--video", a->video, "Write a film (.mp4, .avi) instead of opening a window");
  command->add_option("--speed", a->player.speed, "Times as fast as the recording (default 1)")
      ->check(CLI::Range(0.01, 100.0));
  command->add_option("--start-s", a->player.start_s, "Show from here on [s from the first image]")
      ->check(CLI::Range(0.0, 1e9));
  command->add_option("--end-s", a->player.end_s, "End here")->check(CLI::Range(0.0, 1e9));
  addCalibrationOption(*command, a->run.calibration,
                       "File that goes before the calibration in the recording");
  command->add_option("--set", a->run.assignments, "Section.key=value, before what the ini says")
      ->allow_extra_args(false);
  command->callback([a, &common] {
    catchInterrupt();
    refuseToOverwrite(a->video, Written::film, common);
    view(*a, common);
  });
}

}  // namespace vir::app
