#pragma once
/// Where libraries report: they never print. The app decides what becomes of a line.
#include <functional>
#include <string>

namespace vir {
inline namespace core {

enum class LogLevel { debug, info, warning, error };

/// Receives (level, one line without line break). An empty function drops everything.
using LogSink = std::function<void(LogLevel, const std::string&)>;

inline void log(const LogSink& sink, LogLevel level, const std::string& text) {
  if (sink) sink(level, text);
}

}  // namespace core
}  // namespace vir
