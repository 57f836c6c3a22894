#include "vir/rawlog/mrpt_error.h"

namespace vir::rawlog {
namespace {

constexpr const char* kBlank = " \t\r\n";

/// Between MRPT's headline and its stack trace, and of that what the thrower wrote.
std::string messageOf(std::string text) {
  static const std::string kHeadline = "==== MRPT exception ====", kMark = "Message:";
  const std::size_t headline = text.find(kHeadline);
  if (headline != std::string::npos) text = text.substr(headline + kHeadline.size());
  text = text.substr(0, text.find("Call stack backtrace"));
  const std::size_t mark = text.find(kMark);
  if (mark != std::string::npos) text = text.substr(mark + kMark.size());
  // Says nothing to who does not know MRPT's sources.
  if (text.find("Exception while parsing typed object") != std::string::npos) {
    return "what stands there is no object of a rawlog";
  }
  return text;
}

}  // namespace

std::string shortReason(const std::exception& e) {
  std::string text = messageOf(e.what());
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string::npos) return "unknown reason";
  text = text.substr(first, text.find('\n', first) - first);
  return text.substr(0, text.find_last_not_of(kBlank) + 1);
}

std::string withoutStackTrace(const std::exception& e) {
  const std::string text = e.what();
  const bool of_mrpt = text.find("Call stack backtrace") != std::string::npos ||
                       text.find("MRPT exception") != std::string::npos;
  return of_mrpt ? shortReason(e) : text;
}

}  // namespace vir::rawlog
