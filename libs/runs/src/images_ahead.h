#pragma once
/// Images of a recording, decoded before their turn: reading a PNG costs as much as all that the
/// estimator does with it.
#include <mrpt/obs/CObservationImage.h>

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace vir::runs {

/// A thread that loads images in the order in which they are given. Called from one other thread.
class ImagesAhead {
 public:
  /// One image on its way.
  struct Loading {
    mrpt::obs::CObservationImage::Ptr image;
    std::string problem;  ///< why it cannot be used; empty if it can
    bool done = false;    ///< under the lock of the thread that loads
  };

  ImagesAhead();
  /// Leaves what was not begun.
  ~ImagesAhead();

  /// Until wait() has returned nobody else may touch the image.
  std::shared_ptr<Loading> begin(mrpt::obs::CObservationImage::Ptr image);
  void wait(const Loading& loading);
  /// CPU time that loading has taken so far [s].
  double cpuSeconds() const;

 private:
  void work();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::shared_ptr<Loading>> queue_;
  bool stop_ = false;
  std::thread thread_;
  clockid_t clock_{};
  double cpu_s_ = 0;  // where there is no thread
};

}  // namespace vir::runs
