#pragma once
#include <exception>
#include <string>

namespace vir::rawlog {

/// What an MRPT exception says, without its stack trace: one line.
std::string shortReason(const std::exception& e);

/// The same; what MRPT did not write stays as it is, however many lines it has.
std::string withoutStackTrace(const std::exception& e);

}  // namespace vir::rawlog
