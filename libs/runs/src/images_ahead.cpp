#include "images_ahead.h"

#include <pthread.h>

#include <system_error>
#include <utility>

#include "vir/core/resource_usage.h"
#include "vir/rawlog/mrpt_error.h"

namespace vir::runs {
namespace {

/// An external image is read from the disk.
std::string load(mrpt::obs::CObservationImage& observation) {
  try {
    observation.load();
    return observation.image.isEmpty() ? "it is empty" : "";
  } catch (const std::exception& e) {
    return rawlog::shortReason(e);
  }
}

}  // namespace

ImagesAhead::ImagesAhead() {
  try {
    thread_ = std::thread([this] { work(); });
    pthread_getcpuclockid(thread_.native_handle(), &clock_);
  } catch (const std::system_error&) {
    // No room for a thread: each image is loaded when it is given.
  }
}

ImagesAhead::~ImagesAhead() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::shared_ptr<ImagesAhead::Loading> ImagesAhead::begin(mrpt::obs::CObservationImage::Ptr image) {
  auto loading = std::make_shared<Loading>();
  loading->image = std::move(image);
  if (!thread_.joinable()) {
    const double before = threadCpuSeconds();
    loading->problem = load(*loading->image);
    loading->done = true;
    cpu_s_ += threadCpuSeconds() - before;
    return loading;
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    queue_.push_back(loading);
  }
  changed_.notify_all();
  return loading;
}

void ImagesAhead::wait(const Loading& loading) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [&] { return loading.done; });
}

double ImagesAhead::cpuSeconds() const {
  return thread_.joinable() ? clockSeconds(clock_) : cpu_s_;
}

void ImagesAhead::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_ || !queue_.empty(); });
    if (stop_) return;
    const std::shared_ptr<Loading> loading = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    std::string problem = load(*loading->image);
    lock.lock();
    loading->problem = std::move(problem);
    loading->done = true;
    changed_.notify_all();
  }
}

}  // namespace vir::runs
