#include "loop_worker.h"

#include <algorithm>

namespace vir::estimator {
namespace {

/// Images by which an answer counts later than it could: by far longer than it takes, at 20 images
/// a second and 20 ms for a keyframe; and one more for so many keyframes, since a solution of the
/// graph takes the longer the more there are (0.4 s for 1400).
constexpr long kLateImages = 5, kKeyframesPerImage = 150;

}  // namespace

std::vector<FollowedPose> FollowedPath::with(const std::vector<FollowedPose>& followed) const {
  std::vector<FollowedPose> out = settled_;
  for (const FollowedPose& k : followed) {
    if (out.empty() || k.t > out.back().t) out.push_back(k);
  }
  return out;
}

LoopWorker::LoopWorker(const mission::LoopOptions& options, const Calibration& calibration,
                       bool late, bool thread)
    : late_(late || thread),
      closer_(options, calibration, [this](LogLevel level, const std::string& text) {
        said_.emplace_back(level, text);
      }) {
  if (thread) thread_ = std::thread([this] { workOn(); });
}

LoopWorker::~LoopWorker() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

LoopAnswer LoopWorker::work(const LoopJob& job) {
  const std::lock_guard<std::mutex> lock(closer_mutex_);
  path_.settle(job.settled);
  if (!closer_.found()) closer_.setAnchors(job.anchors);
  closer_.add(job.seen);
  if (closer_.solveDue()) closer_.solve(path_.with(job.followed));
  return {closer_.now(), closer_.found(), closer_.takeRevision(), std::exchange(said_, {})};
}

void LoopWorker::workOn() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return closing_ || !jobs_.empty(); });
    if (closing_) return;
    const LoopJob job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    try {
      LoopAnswer answer = work(job);
      lock.lock();
      answers_.push_back(std::move(answer));
    } catch (...) {
      lock.lock();
      problem_ = std::current_exception();
    }
    changed_.notify_all();
    if (problem_) return;
  }
}

void LoopWorker::give(LoopJob job, long image) {
  std::unique_lock<std::mutex> lock(mutex_);
  if (problem_) std::rethrow_exception(problem_);
  const long later = late_ ? kLateImages + given_ / kKeyframesPerImage : 0;
  last_due_ = std::max(last_due_, image + later);
  ++given_;
  if (thread_.joinable()) {
    jobs_.push_back(std::move(job));
  } else {
    answers_.push_back(work(job));
  }
  due_.push_back(last_due_);
  lock.unlock();
  changed_.notify_all();
}

LoopAnswer LoopWorker::next(std::unique_lock<std::mutex>& lock) {
  changed_.wait(lock, [this] { return problem_ || !answers_.empty(); });
  if (answers_.empty()) std::rethrow_exception(problem_);
  LoopAnswer out = std::move(answers_.front());
  answers_.pop_front();
  due_.pop_front();
  return out;
}

std::optional<LoopAnswer> LoopWorker::take(long image) {
  std::unique_lock<std::mutex> lock(mutex_);
  if (due_.empty() || due_.front() > image) return std::nullopt;
  return next(lock);
}

std::optional<LoopAnswer> LoopWorker::takeAny() {
  std::unique_lock<std::mutex> lock(mutex_);
  if (due_.empty()) return std::nullopt;
  return next(lock);
}

}  // namespace vir::estimator
