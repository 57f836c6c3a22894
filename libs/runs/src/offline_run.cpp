#include "vir/runs/offline_run.h"

#include <mrpt/obs/CObservationImage.h>

#include <algorithm>
#include <map>
#include <utility>

#include "vir/core/resource_usage.h"
#include "vir/core/settings.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_error.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/ordered_reader.h"

namespace vir::runs {
namespace {

using mrpt::obs::CObservation;
using mrpt::obs::CObservationImage;

constexpr long kReportEvery = 50;  // observations between two calls of the progress hook

/// Stamps of what an estimator gives a state for.
struct Frames {
  long count = 0;
  TimeNs first = 0, last = 0;

  void add(TimeNs t) {
    if (count++ == 0) first = t;
    last = t;
  }
};

class OfflineRun {
 public:
  OfflineRun(roles::Estimator& estimator, const OfflineRunOptions& options,
             const results::ResultsFolder& folder, const OfflineRunHooks& hooks)
      : estimator_(estimator),
        options_(options),
        hooks_(hooks),
        input_(options.rawlog),
        recorder_(folder, hooks.log) {
    recorder_.setTrueAnchors(options.true_anchors);
  }

  results::RunSummary run() {
    const double wall = wallSeconds();
    const double cpu = cpuSeconds();
    try {
      play();
    } catch (const SettingsError&) {
      throw;
    } catch (const std::exception& e) {
      summary_.error = rawlog::shortReason(e);
      log(hooks_.log, LogLevel::error, "the run ends early: " + summary_.error);
    }
    summary_.wall_s = wallSeconds() - wall;
    summary_.cpu_s = cpuSeconds() - cpu;
    summarise();
    return summary_;
  }

 private:
  void play() {
    while (!stopRequested()) {
      const auto observation = input_.next();
      if (!observation) break;
      handle(observation);
      reportProgress();
    }
    if (stopRequested()) {
      summary_.interrupted = true;
      warn("interrupted: the results end where the run was stopped");
    }
    timed([&] { estimator_.finish(); });
    collect();
  }

  void handle(const CObservation::Ptr& observation) {
    const TimeNs t = rawlog::fromMrptTime(observation->timestamp);
    const auto as = options_.labels.find(observation->sensorLabel);
    if (as != options_.labels.end()) observation->sensorLabel = as->second;
    if (observation->sensorLabel == rawlog::kGroundTruthLabel) {
      if (const auto pose = rawlog::poseOf(*observation)) {
        recorder_.addGroundTruth(pose->t, pose->T_W_B);
      }
      return;
    }
    const auto image = std::dynamic_pointer_cast<CObservationImage>(observation);
    const bool odometry = !image && observation->sensorLabel == rawlog::kOdometryLabel;
    const bool seen = rawlog::isImage(*observation);
    if ((seen || odometry) && !first_recorded_) first_recorded_ = t;
    if (beforeStart(t)) return;
    if (seen && !options_.inputs.empty() && !roles::takes(options_.inputs, *observation)) {
      ++counters_["images_of_other_cameras"];
      return;
    }
    if (image && !decode(*image)) return;
    if (hooks_.prepare) hooks_.prepare(observation.get());
    if (seen) images_.add(t);
    if (odometry) odometry_.add(t);
    recorder_.onObservation(*observation);
    for (results::RunObserver* o : hooks_.observers) o->onObservation(*observation);
    timed([&] { estimator_.add(*observation); });
    if (image) image->image.unload();
    collect();
  }

  bool beforeStart(TimeNs t) const {
    if (options_.start_offset_s <= 0) return false;
    return !first_recorded_ || t < *first_recorded_ + fromSeconds(options_.start_offset_s);
  }

  /// An external image is read from disk here, so that its decoding is not the estimator's time.
  bool decode(CObservationImage& observation) {
    std::string reason = "it is empty";
    try {
      observation.load();
      if (!observation.image.isEmpty()) return true;
    } catch (const std::exception& e) {
      reason = rawlog::shortReason(e);
    }
    if (counters_["images_unreadable"]++ == 0) {
      warn("image at " + evaluation::formatSeconds(rawlog::fromMrptTime(observation.timestamp)) +
           " s cannot be used: " + reason + " (further ones are only counted)");
    }
    return false;
  }

  void collect() {
    roles::EstimatorOutput output;
    timed([&] { output = estimator_.take(); });
    recorder_.onOutput(output, estimator_);
    for (results::RunObserver* o : hooks_.observers) o->onOutput(output, estimator_);
  }

  template <typename Work>
  void timed(Work work) {
    const double before = cpuSeconds();
    work();
    estimator_cpu_s_ += cpuSeconds() - before;
  }

  bool stopRequested() const { return hooks_.stop && hooks_.stop(); }

  void reportProgress() {
    if (hooks_.progress && ++seen_ % kReportEvery == 0) hooks_.progress(input_.reader().progress());
  }

  void warn(const std::string& text) {
    log(hooks_.log, LogLevel::warning, text);
    summary_.warnings.push_back(text);
  }

  void warnAboutInput() {
    const rawlog::RawlogReader& reader = input_.reader();
    summary_.damaged = !reader.damage().empty();
    for (const std::string& problem : {reader.damage(), reader.refusals()}) {
      if (!problem.empty()) warn(problem);
    }
    for (const TimeNs gap : input_.orderer().gaps()) {
      warn("the recording has a gap of " + evaluation::formatSeconds(gap) + " s");
    }
    if (reader.skipped() > 0) {
      counters_["objects_skipped"] = static_cast<long>(reader.skipped());
    }
    for (const auto& [name, count] : input_.orderer().counters()) {
      counters_[name] = count;
      warn(std::to_string(count) + " observations left out (" + name + ")");
    }
    if (summary_.frames == 0) warn("no usable image and no odometry in " + options_.rawlog);
  }

  void summarise() {
    const Frames& frames = images_.count > 0 ? images_ : odometry_;
    summary_.frames = frames.count;
    summary_.duration_s = toSeconds(frames.last - frames.first);
    warnAboutInput();
    summary_.estimator = options_.estimator;
    summary_.rawlog = options_.rawlog;
    summary_.command = options_.command;
    counters_["objects_read"] = static_cast<long>(input_.reader().objects());
    summary_.counters.assign(counters_.begin(), counters_.end());
    results::takeReport(estimator_.report(), &summary_);
    if (summary_.frames > 0) {
      summary_.cpu_ms_per_frame = 1e3 * estimator_cpu_s_ / static_cast<double>(summary_.frames);
    }
    recorder_.setFirstFrame(frames.first);
    for (results::RunObserver* o : hooks_.observers) o->onEnd(estimator_, &summary_);
    recorder_.onEnd(estimator_, &summary_);
    summary_.peak_rss_mb = peakRssMb();
  }

  roles::Estimator& estimator_;
  const OfflineRunOptions& options_;
  const OfflineRunHooks& hooks_;
  rawlog::OrderedReader input_;
  results::RunRecorder recorder_;
  results::RunSummary summary_;
  std::map<std::string, long> counters_;
  std::optional<TimeNs> first_recorded_;  // image or odometry pose
  Frames images_, odometry_;
  double estimator_cpu_s_ = 0;
  long seen_ = 0;
};

}  // namespace

results::RunSummary runOffline(roles::Estimator& estimator, const OfflineRunOptions& options,
                               const results::ResultsFolder& folder, const OfflineRunHooks& hooks) {
  return OfflineRun(estimator, options, folder, hooks).run();
}

}  // namespace vir::runs
