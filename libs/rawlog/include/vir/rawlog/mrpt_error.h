#pragma once
#include <exception>
#include <string>

namespace vir::rawlog {

/// What an MRPT exception says, without its stack trace: one line.
std::string shortReason(const std::exception& e);

}  // namespace vir::rawlog
