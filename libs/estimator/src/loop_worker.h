#pragma once
/// Internal: keyframes on their way to the loop closer and its answers, in the caller's thread or
/// in one of its own. When an answer counts is said by the number of images, not by a clock: what
/// comes out depends on that, not on the threads.
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "vir/mission/loop_closer.h"
#include "vir/types/followed_pose.h"

namespace vir::estimator {

struct LoopJob {
  mission::SeenKeyframe seen;  ///< of `gray`
  cv::Mat gray;
  std::vector<Anchor> anchors;         ///< where they are still needed to be found in a map
  std::vector<FollowedPose> settled;   ///< since the last job
  std::vector<FollowedPose> followed;  ///< those that were not, all of them
};

struct LoopAnswer {
  mission::Correction correction;
  bool found = true;
  std::optional<Revision> revision;
  std::vector<std::pair<LogLevel, std::string>> said;
};

/// The estimator's keyframes as they are known by now.
class FollowedPath {
 public:
  void settle(const std::vector<FollowedPose>& more) {
    settled_.insert(settled_.end(), more.begin(), more.end());
  }
  std::vector<FollowedPose> with(const std::vector<FollowedPose>& followed) const;

 private:
  std::vector<FollowedPose> settled_;
};

class LoopWorker {
 public:
  /// `late`: answers count some images later than they could, so that they can be worked out in the
  /// meantime. `thread`: they are, in a thread of their own.
  LoopWorker(const mission::LoopOptions& options, const Calibration& calibration, bool late,
             bool thread);
  ~LoopWorker();

  /// At the image of this number, which rises. Throws what the closer threw at an earlier job.
  void give(LoopJob job, long image);
  /// The oldest answer that counts at this image; waits for it. Throws as give().
  std::optional<LoopAnswer> take(long image);
  /// The oldest answer that is not taken yet, whenever it was to count.
  std::optional<LoopAnswer> takeAny();

  /// For the caller alone as long as `Access` lives: waits for the job at work, not for others.
  struct Access {
    std::unique_lock<std::mutex> lock;
    mission::LoopCloser& closer;
    FollowedPath& path;
    std::vector<std::pair<LogLevel, std::string>>& said;  ///< outside of jobs, too
  };
  Access open() { return {std::unique_lock<std::mutex>(closer_mutex_), closer_, path_, said_}; }

 private:
  LoopAnswer work(const LoopJob& job);
  void workOn();
  /// The front of answers_; waits for it.
  LoopAnswer next(std::unique_lock<std::mutex>& lock);

  const bool late_;
  std::mutex closer_mutex_;  // of what follows
  std::vector<std::pair<LogLevel, std::string>> said_;
  mission::LoopCloser closer_;
  FollowedPath path_;

  std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  std::deque<LoopJob> jobs_;
  std::deque<long> due_;  ///< of the jobs whose answer is not taken yet
  std::deque<LoopAnswer> answers_;
  long given_ = 0, last_due_ = 0;
  std::exception_ptr problem_;
  bool closing_ = false;
  std::thread thread_;
};

}  // namespace vir::estimator
