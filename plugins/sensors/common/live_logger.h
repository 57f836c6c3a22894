#pragma once
#include <mrpt/system/COutputLogger.h>

#include "vir/core/log.h"

namespace vir {

/// A sink that writes to an MRPT logger, which must outlive it.
inline LogSink sinkOf(mrpt::system::COutputLogger* logger) {
  return [logger](LogLevel level, const std::string& text) {
    using mrpt::system::VerbosityLevel;
    const VerbosityLevel verbosity = level == LogLevel::error     ? mrpt::system::LVL_ERROR
                                     : level == LogLevel::warning ? mrpt::system::LVL_WARN
                                     : level == LogLevel::info    ? mrpt::system::LVL_INFO
                                                                  : mrpt::system::LVL_DEBUG;
    logger->logStr(verbosity, text);
  };
}

}  // namespace vir
