#include "vir/live/live_estimation.h"

#include <algorithm>
#include <utility>

#include "vir/core/resource_usage.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_error.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir::live {
namespace {

using mrpt::obs::CObservation;

}  // namespace

LiveEstimation::LiveEstimation(roles::EstimatorSettings& settings,
                               const results::ResultsFolder& folder,
                               const LiveEstimationOptions& options, LiveEstimationHooks hooks)
    : inputs_(settings.inputs()),
      options_(options),
      hooks_(std::move(hooks)),
      recorder_(folder, hooks_.log),
      propagator_(settings.gravity()),
      wall_from_(wallSeconds()) {
  behind_ = options_.pipelined && settings.workBehind();
  estimator_ =
      settings.create(hooks_.log, behind_ ? std::function<void()>([this] { collect(); }) : nullptr);
  thread_ = std::thread([this] { work(); });
}

LiveEstimation::~LiveEstimation() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    closing_ = true;
    queue_.clear();
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
  if (finished_ || !behind_) return;
  try {
    estimator_->finish();  // its thread calls collect() until then
  } catch (const std::exception& e) {
    log(hooks_.log, LogLevel::error, "estimating ended: " + rawlog::shortReason(e));
  }
}

void LiveEstimation::add(const std::vector<Arrival>& arrivals) {
  std::vector<Arrival> read;
  for (const Arrival& a : arrivals) {
    const bool truth = a.observation->sensorLabel == rawlog::kGroundTruthLabel;
    if (truth || followed(*a.observation)) read.push_back(a);
  }
  for (const Arrival& a : read) propagate(a);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const Arrival& a : read) {
      queue_.push_back(a);
      if (!rawlog::isImage(*a.observation)) continue;
      // Of each camera its own: a pair that waits is no reason to part it.
      const std::string& camera = a.observation->sensorLabel;
      if (++waiting_images_[camera] <= options_.waiting_images) continue;
      const auto oldest = std::find_if(queue_.begin(), queue_.end(), [&](const Arrival& waiting) {
        return rawlog::isImage(*waiting.observation) && waiting.observation->sensorLabel == camera;
      });
      queue_.erase(oldest);
      --waiting_images_[camera];
      ++dropped_;
    }
  }
  wake_.notify_one();
}

bool LiveEstimation::followed(const CObservation& observation) const {
  if (roles::takes(inputs_, observation)) return true;
  // Images of a second camera must not push out those that are waited for.
  return !hooks_.observers.empty() && !rawlog::isImage(observation);
}

void LiveEstimation::propagate(const Arrival& arrival) {
  if (!hooks_.on_pose || !roles::takes(inputs_, *arrival.observation)) return;
  const auto sample = rawlog::imuSampleOf(*arrival.observation);
  if (!sample || !sample->acc.allFinite() || !sample->gyro.allFinite()) return;
  if (const auto pose = propagator_.add(*sample)) hooks_.on_pose(*pose, sample->gyro - pose->bg);
}

void LiveEstimation::work() {
  while (true) {
    Arrival next;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      wake_.wait(lock, [this] { return closing_ || !queue_.empty(); });
      if (queue_.empty()) break;
      next = std::move(queue_.front());
      queue_.pop_front();
      if (rawlog::isImage(*next.observation)) {
        --waiting_images_[next.observation->sensorLabel];
      }
    }
    if (!problem().empty()) continue;
    try {
      handle(next);
    } catch (const std::exception& e) {
      fail(e);
    }
  }
}

void LiveEstimation::fail(const std::exception& e) {
  log(hooks_.log, LogLevel::error, "estimating ends here: " + rawlog::shortReason(e));
  const std::lock_guard<std::mutex> lock(mutex_);
  problem_ = rawlog::shortReason(e);
}

void LiveEstimation::handle(const Arrival& arrival) {
  const CObservation& observation = *arrival.observation;
  const TimeNs t = rawlog::fromMrptTime(observation.timestamp);
  if (observation.sensorLabel == rawlog::kGroundTruthLabel) {
    const auto pose = rawlog::poseOf(observation);
    const std::lock_guard<std::mutex> lock(results_mutex_);
    if (pose) recorder_.addGroundTruth(pose->t, pose->T_W_B);
    return;
  }
  if (!hooks_.observers.empty()) {
    const std::lock_guard<std::mutex> lock(results_mutex_);
    for (results::RunObserver* o : hooks_.observers) o->onObservation(observation);
  }
  if (!roles::takes(inputs_, observation)) return;
  if ((rawlog::isImage(observation) || observation.sensorLabel == rawlog::kOdometryLabel) &&
      !roles::isOfFurtherCamera(inputs_, observation)) {
    if (!first_frame_) first_frame_ = t;
    last_frame_ = t;
    ++summary_.frames;
    const std::lock_guard<std::mutex> lock(results_mutex_);
    arrivals_[t] = arrival.arrival;
  }
  const double before = threadCpuSeconds();
  estimator_->add(observation);
  if (!behind_) collect();
  cpu_s_ += threadCpuSeconds() - before;
}

void LiveEstimation::collect() {
  const std::lock_guard<std::mutex> results(results_mutex_);
  const roles::EstimatorOutput output = estimator_->take();
  for (const StateEstimate& estimate : output.states) {
    if (estimate.valid) {
      propagator_.setState(estimate.state);
    } else {
      propagator_.clear();
    }
    const auto arrival = arrivals_.find(estimate.t_image);
    if (arrival != arrivals_.end()) {
      const double ms = 1e3 * toSeconds(hostNow() - arrival->second);
      arrivals_.erase(arrivals_.begin(), std::next(arrival));
      const std::lock_guard<std::mutex> lock(mutex_);
      latencies_.add(ms);
    }
    estimate_ms_ += estimate.ms.total;
  }
  recorder_.onOutput(output, *estimator_);
  for (results::RunObserver* o : hooks_.observers) o->onOutput(output, *estimator_);
}

results::RunSummary LiveEstimation::finish() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    closing_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
  // Its thread may call collect() until then, whatever has happened.
  if (behind_ || problem().empty()) {
    try {
      estimator_->finish();
      collect();
    } catch (const std::exception& e) {
      if (problem().empty()) fail(e);
    }
  }
  finished_ = true;
  results::takeReport(estimator_->report(), &summary_);
  summary_.counters.emplace_back("images_dropped_late", imagesDropped());
  summary_.error = problem();
  summary_.duration_s = first_frame_ ? toSeconds(last_frame_ - *first_frame_) : 0;
  summary_.wall_s = wallSeconds() - wall_from_;
  // A thread of the estimator's own is seen by its estimates only.
  summary_.cpu_s = behind_ ? 1e-3 * estimate_ms_ : cpu_s_;
  if (summary_.frames > 0) {
    summary_.cpu_ms_per_frame = 1e3 * summary_.cpu_s / static_cast<double>(summary_.frames);
  }
  for (results::RunObserver* o : hooks_.observers) o->onEnd(*estimator_, &summary_);
  recorder_.setFirstFrame(first_frame_.value_or(0));
  recorder_.onEnd(*estimator_, &summary_);
  summary_.peak_rss_mb = peakRssMb();
  return summary_;
}

Latency LiveEstimation::latency() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return latencies_.summary();
}

long LiveEstimation::imagesDropped() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return dropped_;
}

std::string LiveEstimation::problem() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return problem_;
}

}  // namespace vir::live
