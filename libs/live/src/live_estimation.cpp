#include "vir/live/live_estimation.h"

#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationStereoImagesFeatures.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "vir/core/resource_usage.h"
#include "vir/rawlog/mrpt_error.h"
#include "vir/rawlog/mrpt_pose.h"
#include "vir/rawlog/mrpt_time.h"

namespace vir::live {
namespace {

using mrpt::obs::CObservation;
using mrpt::obs::CObservationIMU;

constexpr const char* kGroundTruthLabel = "GT";

bool isFrame(const CObservation& o) {
  return dynamic_cast<const mrpt::obs::CObservationImage*>(&o) != nullptr ||
         dynamic_cast<const mrpt::obs::CObservationStereoImagesFeatures*>(&o) != nullptr;
}

double threadCpuSeconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

bool readImu(const CObservation& observation, imu::ImuSample* sample) {
  using namespace mrpt::obs;
  const auto* imu = dynamic_cast<const CObservationIMU*>(&observation);
  if (imu == nullptr) return false;
  for (const auto index : {IMU_X_ACC, IMU_Y_ACC, IMU_Z_ACC, IMU_WX, IMU_WY, IMU_WZ}) {
    if (!imu->has(index)) return false;
  }
  sample->t = rawlog::fromMrptTime(imu->timestamp);
  sample->acc = Vec3(imu->get(IMU_X_ACC), imu->get(IMU_Y_ACC), imu->get(IMU_Z_ACC));
  sample->gyro = Vec3(imu->get(IMU_WX), imu->get(IMU_WY), imu->get(IMU_WZ));
  return sample->acc.allFinite() && sample->gyro.allFinite();
}

}  // namespace

LiveEstimation::LiveEstimation(roles::Estimator& estimator, const results::ResultsFolder& folder,
                               const LiveEstimationOptions& options, LiveEstimationHooks hooks)
    : estimator_(estimator),
      options_(options),
      hooks_(std::move(hooks)),
      recorder_(folder, hooks_.log),
      wall_from_(wallSeconds()) {
  behind_ = options_.pipelined && estimator_.workBehind([this] { collect(); });
  estimator_.start(hooks_.log);
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
    estimator_.finish();  // its thread calls collect() until then
  } catch (const std::exception& e) {
    log(hooks_.log, LogLevel::error, "estimating ended: " + rawlog::shortReason(e));
  }
}

void LiveEstimation::add(const std::vector<Arrival>& arrivals) {
  std::vector<Arrival> read;
  for (const Arrival& a : arrivals) {
    const bool truth = a.observation->sensorLabel == kGroundTruthLabel;
    if (truth || estimator_.reads(*a.observation)) read.push_back(a);
  }
  for (const Arrival& a : read) propagate(a);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const Arrival& a : read) {
      queue_.push_back(a);
      if (!isFrame(*a.observation) || ++waiting_images_ <= options_.waiting_images) continue;
      const auto oldest = std::find_if(queue_.begin(), queue_.end(), [](const Arrival& waiting) {
        return isFrame(*waiting.observation);
      });
      queue_.erase(oldest);
      --waiting_images_;
      ++dropped_;
    }
  }
  wake_.notify_one();
}

void LiveEstimation::propagate(const Arrival& arrival) {
  imu::ImuSample sample;
  if (!hooks_.on_pose || !readImu(*arrival.observation, &sample)) return;
  if (const auto pose = propagator_.add(sample)) hooks_.on_pose(*pose);
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
      if (isFrame(*next.observation)) --waiting_images_;
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
  if (observation.sensorLabel == kGroundTruthLabel) {
    const auto* pose = dynamic_cast<const mrpt::obs::CObservationRobotPose*>(&observation);
    const std::lock_guard<std::mutex> lock(results_mutex_);
    if (pose != nullptr) recorder_.addGroundTruth(t, rawlog::fromMrptPose(pose->pose.mean));
    return;
  }
  if (isFrame(observation) || observation.sensorLabel == "ODOM") {
    if (!first_frame_) first_frame_ = t;
    last_frame_ = t;
    ++summary_.frames;
    const std::lock_guard<std::mutex> lock(results_mutex_);
    arrivals_[t] = arrival.arrival;
  }
  const double before = threadCpuSeconds();
  estimator_.add(observation);
  if (!behind_) collect();
  cpu_s_ += threadCpuSeconds() - before;
}

void LiveEstimation::collect() {
  const std::lock_guard<std::mutex> results(results_mutex_);
  for (const roles::StateEstimate& estimate : estimator_.take()) {
    if (estimate.valid) {
      propagator_.setState(estimate.t_imu, estimate.T_W_B, estimate.v_W_B, estimate.bias_gyro,
                           estimate.bias_acc);
    } else {
      propagator_.clear();
    }
    const auto arrival = arrivals_.find(estimate.t);
    if (arrival != arrivals_.end()) {
      const double ms = 1e3 * toSeconds(hostNow() - arrival->second);
      arrivals_.erase(arrivals_.begin(), std::next(arrival));
      const std::lock_guard<std::mutex> lock(mutex_);
      latencies_ms_.push_back(static_cast<float>(ms));
    }
    recorder_.add(estimate);
    estimate_ms_ += estimate.ms.total;
    if (hooks_.on_estimate) hooks_.on_estimate(estimate, estimator_);
  }
  for (const roles::RangeRecord& range : estimator_.takeRanges()) recorder_.add(range);
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
      estimator_.finish();
      collect();
    } catch (const std::exception& e) {
      if (problem().empty()) fail(e);
    }
  }
  finished_ = true;
  const roles::EstimatorReport report = estimator_.report();
  summary_.resets = report.resets;
  summary_.longest_wait_reason = report.longest_wait_reason;
  summary_.counters = report.counters;
  summary_.warnings = report.warnings;
  summary_.counters.emplace_back("images_dropped_late", imagesDropped());
  summary_.error = problem();
  summary_.duration_s = first_frame_ ? toSeconds(last_frame_ - *first_frame_) : 0;
  summary_.wall_s = wallSeconds() - wall_from_;
  // A thread of the estimator's own is seen by its estimates only.
  summary_.cpu_s = behind_ ? 1e-3 * estimate_ms_ : cpu_s_;
  if (summary_.frames > 0) {
    summary_.cpu_ms_per_frame = 1e3 * summary_.cpu_s / static_cast<double>(summary_.frames);
  }
  recorder_.finish(estimator_, first_frame_.value_or(0), &summary_);
  summary_.peak_rss_mb = peakRssMb();
  return summary_;
}

Latency LiveEstimation::latency() const {
  std::vector<float> all;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    all = latencies_ms_;
  }
  Latency out;
  out.count = static_cast<long>(all.size());
  if (all.empty()) return out;
  std::sort(all.begin(), all.end());
  const auto quantile = [&all](double p) {
    return static_cast<double>(
        all[static_cast<std::size_t>(p * static_cast<double>(all.size() - 1))]);
  };
  out.median_ms = quantile(0.5);
  out.p95_ms = quantile(0.95);
  out.p99_ms = quantile(0.99);
  out.max_ms = all.back();
  return out;
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
