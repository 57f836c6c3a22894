#include "hand_over.h"

#include <stdexcept>
#include <utility>

namespace vir::estimator {

HandOver::~HandOver() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    closing_ = true;
    packets_.clear();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void HandOver::startThread(std::function<void()> done) {
  if (lag_ < 1) throw std::logic_error("HandOver: a thread needs a lag of at least 1");
  if (given_ > 0 || thread_.joinable()) throw std::logic_error("HandOver: it has begun already");
  done_ = std::move(done);
  thread_ = std::thread([this] { work(); });
}

void HandOver::give(Packet packet) {
  std::unique_lock<std::mutex> lock(mutex_);
  rethrow(lock);
  ++given_;
  if (thread_.joinable()) {
    packets_.push_back(std::move(packet));
    lock.unlock();
    changed_.notify_all();
    return;
  }
  lock.unlock();
  try {
    finished(process_(std::move(packet)));
  } catch (...) {
    lock.lock();
    problem_ = std::current_exception();
    throw;
  }
}

Feedback HandOver::ask(long* covered) {
  std::unique_lock<std::mutex> lock(mutex_);
  *covered = given_ > lag_ ? given_ - lag_ : 0;
  changed_.wait(lock, [&] { return processed_ >= *covered || problem_; });
  rethrow(lock);
  known_.wrong_tracks.clear();
  for (; asked_ < *covered; ++asked_) {
    Feedback& next = feedback_.front();
    next.wrong_tracks.insert(next.wrong_tracks.begin(), known_.wrong_tracks.begin(),
                             known_.wrong_tracks.end());
    known_ = std::move(next);
    feedback_.pop_front();
  }
  return known_;
}

void HandOver::wait() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [&] { return processed_ >= given_ || problem_; });
}

void HandOver::drain() {
  wait();
  std::unique_lock<std::mutex> lock(mutex_);
  rethrow(lock);
}

void HandOver::finished(Feedback feedback) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    feedback_.push_back(std::move(feedback));
    ++processed_;
  }
  changed_.notify_all();
}

void HandOver::work() {
  while (true) {
    Packet packet;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [this] { return closing_ || !packets_.empty(); });
      if (closing_) return;
      packet = std::move(packets_.front());
      packets_.pop_front();
    }
    try {
      Feedback feedback = process_(std::move(packet));
      done_();
      finished(std::move(feedback));
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      problem_ = std::current_exception();
      changed_.notify_all();
      return;
    }
  }
}

void HandOver::rethrow(std::unique_lock<std::mutex>& lock) {
  if (!problem_) return;
  const std::exception_ptr problem = problem_;
  lock.unlock();
  std::rethrow_exception(problem);
}

}  // namespace vir::estimator
