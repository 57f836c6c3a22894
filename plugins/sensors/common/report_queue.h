#pragma once
#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "vir/core/log.h"
#include "vir/roles/live_source.h"

namespace vir {

/// What a live sensor has to say, kept until somebody asks; bounded.
class ReportQueue {
 public:
  static constexpr std::size_t kMost = 200;  ///< messages kept, and kinds remembered by once()

  /// Every line goes here as well, at once.
  void setSink(LogSink sink) { sink_ = std::move(sink); }
  void say(LogLevel level, const std::string& text) {
    log(sink_, level, text);
    if (waiting_.size() < kMost) waiting_.push_back({level, text});
  }
  /// Says it the first time that `key` comes.
  void once(const std::string& key, LogLevel level, const std::string& text) {
    if (said_.size() < kMost && said_.insert(key).second) say(level, text);
  }
  void forget(const std::string& key) { said_.erase(key); }
  std::vector<roles::SensorMessage> take() {
    std::vector<roles::SensorMessage> out;
    out.swap(waiting_);
    return out;
  }

 private:
  LogSink sink_;
  std::vector<roles::SensorMessage> waiting_;
  std::set<std::string> said_;
};

}  // namespace vir
