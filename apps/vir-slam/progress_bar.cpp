#include "progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace vir::app {

ProgressBar::ProgressBar(std::string title)
    : title_(std::move(title)), terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() { clear(); }

void ProgressBar::clear() {
  if (!terminal_ || shown_ < 0) return;
  std::fprintf(stderr, "\r\033[K");
  std::fflush(stderr);
  shown_ = -1;
}

void ProgressBar::show(double share) {
  if (!terminal_) return;
  const int percent = static_cast<int>(100.0 * std::clamp(share, 0.0, 1.0));
  if (percent == shown_) return;
  shown_ = percent;
  const std::string bar(static_cast<std::size_t>(percent * 40 / 100), '#');
  std::fprintf(stderr, "\r%s [%-40s] %3d %%", title_.c_str(), bar.c_str(), percent);
  std::fflush(stderr);
}

}  // namespace vir::app
