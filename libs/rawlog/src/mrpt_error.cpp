#include "vir/rawlog/mrpt_error.h"

namespace vir::rawlog {

std::string shortReason(const std::exception& e) {
  std::string text = e.what();
  static const std::string kMark = "Message:";
  const std::size_t mark = text.find(kMark);
  if (mark != std::string::npos) text = text.substr(mark + kMark.size());
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return "unknown reason";
  text = text.substr(first, text.find('\n', first) - first);
  return text.substr(0, text.find_last_not_of(" \t\r") + 1);
}

}  // namespace vir::rawlog
