#include "vir/live/live_recorder.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "vir/rawlog/mrpt_error.h"

namespace vir::live {

LiveRecorder::LiveRecorder(const std::string& path, const rawlog::LiveRecordingOptions& recording,
                           const LiveMergerOptions& merging, std::size_t sensors)
    : options_(recording),
      recording_(path, recording),
      merger_(sensors, merging),
      thread_([this] { work(); }) {}

LiveRecorder::~LiveRecorder() {
  try {
    close();
  } catch (const std::exception&) {  // told by problem()
  }
}

void LiveRecorder::add(const std::vector<Arrival>& arrivals) {
  if (arrivals.empty()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    queue_.insert(queue_.end(), arrivals.begin(), arrivals.end());
    counts_.behind_s =
        std::max(counts_.behind_s, toSeconds(arrivals.back().arrival - queue_.front().arrival));
  }
  wake_.notify_one();
}

void LiveRecorder::setEnded(std::size_t sensor) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ended_.push_back(sensor);
}

void LiveRecorder::close() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    closing_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
  const std::string why = problem();
  if (!why.empty()) throw std::runtime_error(why);
}

std::string LiveRecorder::problem() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return problem_;
}

LiveRecorder::Counts LiveRecorder::counts() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counts_;
}

void LiveRecorder::writeReady(TimeNs now) {
  while (const auto item = merger_.pop(now)) {
    ++taken_;
    if (!problem().empty()) continue;
    try {
      recording_.write(*item->observation, item->in_order);
    } catch (const std::exception& e) {
      const std::lock_guard<std::mutex> lock(mutex_);
      problem_ = rawlog::shortReason(e);
    }
  }
  tellCounts();
}

void LiveRecorder::tellCounts() {
  const std::lock_guard<std::mutex> lock(mutex_);
  counts_.written = recording_.written();
  counts_.aside = recording_.asideCount();
  counts_.lost = taken_ - counts_.written - counts_.aside;
  counts_.files = recording_.parts();
  if (counts_.aside > 0) counts_.files.push_back(recording_.asidePath());
}

void LiveRecorder::work() {
  TimeNs last_flush = hostNow();
  bool closing = false;
  while (!closing) {
    std::vector<Arrival> arrivals;
    std::vector<std::size_t> ended;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      wake_.wait_for(lock, std::chrono::milliseconds(20),
                     [this] { return closing_ || !queue_.empty(); });
      arrivals.swap(queue_);
      ended.swap(ended_);
      closing = closing_;
    }
    for (const Arrival& a : arrivals) merger_.push(a.sensor, a.observation, a.arrival);
    for (const std::size_t sensor : ended) merger_.setEnded(sensor);
    if (closing) merger_.flush();
    writeReady(hostNow());
    const TimeNs now = hostNow();
    if (now - last_flush < fromSeconds(options_.flush_s) && !closing) continue;
    last_flush = now;
    if (!problem().empty()) continue;
    try {
      closing ? recording_.close() : recording_.flush();
    } catch (const std::exception& e) {
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        problem_ = rawlog::shortReason(e);
      }
      tellCounts();
    }
  }
}

}  // namespace vir::live
