#pragma once
/// Internal: packets on their way from the front end to the back end, which works in the caller's
/// thread or in one of its own.
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

#include "packet.h"

namespace vir::estimator {

class HandOver {
 public:
  using Process = std::function<Feedback(Packet)>;

  /// `lag`: packets by which feedback comes later than it could: 0 = the tracker knows all, so
  /// that nothing can be done at the same time; 1 = an image can be tracked while the one before it
  /// is worked on. What comes out depends on the lag, not on the threads.
  HandOver(Process process, int lag) : process_(std::move(process)), lag_(lag) {}
  ~HandOver();
  /// From now on packets are processed in a thread of their own, which calls `done` after each.
  /// Needs a lag of at least 1: throws std::logic_error.
  void startThread(std::function<void()> done);

  /// Throws what `process` threw; of a thread's, at the next call of any function here.
  void give(Packet packet);
  /// What is known of all packets but the last `lag`; waits for it. `covered`: how many these are.
  /// Tracks to drop are told once.
  Feedback ask(long* covered);
  /// Waits until nothing is left to do, or nothing more can be done.
  void wait();
  /// The same; throws as give() does.
  void drain();

 private:
  void work();
  void finished(Feedback feedback);
  void rethrow(std::unique_lock<std::mutex>& lock);

  Process process_;
  long lag_ = 0;
  std::function<void()> done_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Packet> packets_;
  std::deque<Feedback> feedback_;  ///< not asked for yet
  Feedback known_;
  long given_ = 0, processed_ = 0, asked_ = 0;
  std::exception_ptr problem_;
  bool closing_ = false;
  std::thread thread_;
};

}  // namespace vir::estimator
