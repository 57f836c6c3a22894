#include "vir/runs/offline_run.h"

#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>

#include <algorithm>
#include <deque>
#include <map>
#include <utility>

#include "images_ahead.h"
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
// Beside the one that is worked on: keyframes take longer than others, decoding always the same.
constexpr int kImagesAhead = 3;
constexpr std::size_t kMostAhead = 512;  // observations read ahead where there are no images

/// Stamps of what an estimator gives a state for.
struct Frames {
  long count = 0;
  TimeNs first = 0, last = 0;

  void add(TimeNs t) {
    if (count++ == 0) first = t;
    last = t;
  }
};

/// An observation that has been read, and whose turn comes later.
struct Waiting {
  CObservation::Ptr observation;
  bool before_start = false, after_end = false, other_camera = false;
  std::shared_ptr<ImagesAhead::Loading> loading;  ///< an image that will be used
};

/// As in RunSummary::left_out; empty for what no estimator reads.
std::string kindOf(const CObservation& observation) {
  if (rawlog::isImage(observation)) return results::kImages;
  if (dynamic_cast<const mrpt::obs::CObservationIMU*>(&observation) != nullptr) {
    return results::kImuReadings;
  }
  if (dynamic_cast<const mrpt::obs::CObservationBeaconRanges*>(&observation) != nullptr) {
    return results::kRanges;
  }
  return observation.sensorLabel == rawlog::kOdometryLabel ? results::kOdometryPoses : "";
}

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
    recorder_.setAnchorTexts(options.anchor_texts);
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
      readAhead();
      if (waiting_.empty()) break;
      const Waiting next = std::move(waiting_.front());
      waiting_.pop_front();
      if (next.after_end) break;
      handle(next);
      reportProgress();
    }
    if (stopRequested()) {
      summary_.interrupted = true;
      warn("interrupted: the results end where the run was stopped");
    }
    roles::EstimatorOutput output;
    timed([&] {
      estimator_.finish();
      output = estimator_.take();
    });
    tell(output);
  }

  /// What there is before the image after the next few, whose decoding begins.
  void readAhead() {
    while (loading_ < kImagesAhead && waiting_.size() < kMostAhead) {
      auto observation = input_.next();
      if (!observation) return;
      giveLabel(observation.get());
      waiting_.push_back(sorted(observation));
      if (waiting_.back().loading) ++loading_;
    }
  }

  /// The one that the estimator reads it under. What it is, is kept under the recording's own.
  void giveLabel(CObservation* observation) {
    const std::string label = observation->sensorLabel;
    const auto as = options_.labels.find(label);
    if (as != options_.labels.end()) observation->sensorLabel = as->second;
    if (kinds_.count(label) > 0) return;
    const bool taken = options_.inputs.empty() || roles::takes(options_.inputs, *observation);
    kinds_.emplace(label, taken ? kindOf(*observation) : "");
  }

  /// Whether it is one to be used, which the ones before it decide.
  Waiting sorted(const CObservation::Ptr& observation) {
    Waiting out{observation, false, false, false, nullptr};
    if (observation->sensorLabel == rawlog::kGroundTruthLabel) return out;
    const TimeNs t = rawlog::fromMrptTime(observation->timestamp);
    const auto image = std::dynamic_pointer_cast<CObservationImage>(observation);
    const bool seen = rawlog::isImage(*observation);
    const bool odometry = !image && observation->sensorLabel == rawlog::kOdometryLabel;
    if ((seen || odometry) && !first_recorded_) first_recorded_ = t;
    out.before_start = beforeStart(t);
    out.after_end = afterEnd(t);
    out.other_camera =
        seen && !options_.inputs.empty() && !roles::takes(options_.inputs, *observation);
    if (image && !out.before_start && !out.other_camera) {
      out.loading = images_ahead_.begin(image);
      any_decoding_ = true;
    }
    return out;
  }

  void handle(const Waiting& next) {
    const CObservation::Ptr& observation = next.observation;
    const TimeNs t = rawlog::fromMrptTime(observation->timestamp);
    if (observation->sensorLabel == rawlog::kGroundTruthLabel) {
      if (const auto pose = rawlog::poseOf(*observation)) {
        recorder_.addGroundTruth(pose->t, pose->T_W_B);
      }
      return;
    }
    if (next.before_start) return;
    if (next.other_camera) {
      ++counters_["images_of_other_cameras"];
      return;
    }
    if (next.loading && !decoded(*next.loading)) return;
    const auto image = std::dynamic_pointer_cast<CObservationImage>(observation);
    if (hooks_.prepare) hooks_.prepare(observation.get());
    // States are of the first camera's images, and pictures show them.
    const bool seen = rawlog::isImage(*observation);
    const bool further = roles::isOfFurtherCamera(options_.inputs, *observation);
    if (seen && !further) images_.add(t);
    if (!image && observation->sensorLabel == rawlog::kOdometryLabel) odometry_.add(t);
    if (!further) recorder_.onObservation(*observation);
    for (results::RunObserver* o : hooks_.observers) o->onObservation(*observation);
    roles::EstimatorOutput output;
    timed([&] {
      estimator_.add(*observation);
      output = estimator_.take();
    });
    if (image) image->image.unload();
    tell(output);
  }

  bool beforeStart(TimeNs t) const {
    if (options_.start_offset_s <= 0) return false;
    return !first_recorded_ || t < *first_recorded_ + fromSeconds(options_.start_offset_s);
  }

  bool afterEnd(TimeNs t) const {
    if (options_.duration_s <= 0 || !first_recorded_) return false;
    return t > *first_recorded_ + fromSeconds(options_.start_offset_s + options_.duration_s);
  }

  /// False, and counted, if the image cannot be used.
  bool decoded(const ImagesAhead::Loading& loading) {
    images_ahead_.wait(loading);
    --loading_;
    if (loading.problem.empty()) return true;
    ++summary_.left_out[results::kImages];
    if (counters_["images_unreadable"]++ == 0) {
      const TimeNs t = rawlog::fromMrptTime(loading.image->timestamp);
      warn("image at " + evaluation::formatSeconds(t) + " s cannot be used: " + loading.problem +
           " (further ones are only counted)");
    }
    return false;
  }

  void tell(const roles::EstimatorOutput& output) {
    recorder_.onOutput(output, estimator_);
    for (results::RunObserver* o : hooks_.observers) o->onOutput(output, estimator_);
  }

  template <typename Work>
  void timed(Work work) {
    const double before = cpuWithoutDecoding();
    work();
    estimator_cpu_s_ += cpuWithoutDecoding() - before;
  }

  /// An estimator may have threads of its own; that of the images is not one of them. Clocks of CPU
  /// time cost a call of the kernel each, for every reading of an IMU: none that is not needed.
  double cpuWithoutDecoding() const {
    return any_decoding_ ? cpuSeconds() - images_ahead_.cpuSeconds() : cpuSeconds();
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
    for (const auto& [label, count] : reader.leftOut()) {
      counters_["implausible_" + label] = count;
      countLeftOut(label, count);
    }
    for (const auto& [label, count] : input_.orderer().sorted()) {
      counters_["sorted_" + label] = count;
      warn(std::to_string(count) + " observations of " + label +
           " came after later ones and were put in order by their stamps: if those were true, this "
           "costs nothing");
    }
    for (const auto& [name, count] : input_.orderer().counters()) {
      counters_[name] = count;
      // Twice the same is no loss.
      for (const char* lost : {"late_", "bad_stamp_"}) {
        const std::string prefix = lost;
        if (name.rfind(prefix, 0) == 0) countLeftOut(name.substr(prefix.size()), count);
      }
      warn(std::to_string(count) + " observations left out (" + name + ")");
    }
    if (summary_.frames == 0) warn("no usable image and no odometry in " + options_.rawlog);
  }

  void countLeftOut(const std::string& label, long count) {
    const auto kind = kinds_.find(label);
    if (kind != kinds_.end() && !kind->second.empty()) summary_.left_out[kind->second] += count;
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
    if (!summary_.interrupted) recorder_.setExplanation(hooks_.explain);
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
  std::map<std::string, std::string> kinds_;  // by label; empty: the estimator does not take it
  std::optional<TimeNs> first_recorded_;      // image or odometry pose
  Frames images_, odometry_;
  double estimator_cpu_s_ = 0;
  long seen_ = 0;
  std::deque<Waiting> waiting_;
  int loading_ = 0;  // of those that wait
  bool any_decoding_ = false;
  ImagesAhead images_ahead_;  // the last member: its thread ends before what it works on
};

}  // namespace

results::RunSummary runOffline(roles::Estimator& estimator, const OfflineRunOptions& options,
                               const results::ResultsFolder& folder, const OfflineRunHooks& hooks) {
  return OfflineRun(estimator, options, folder, hooks).run();
}

}  // namespace vir::runs
