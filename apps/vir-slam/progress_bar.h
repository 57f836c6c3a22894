#pragma once
#include <string>

namespace vir::app {

/// A bar on the standard error stream that is drawn on a terminal only.
class ProgressBar {
 public:
  explicit ProgressBar(std::string title);
  ~ProgressBar();
  /// `share` 0..1. Redraws when the percentage changes.
  void show(double share);
  /// Wipes the line, so that something else can be printed.
  void clear();

 private:
  std::string title_;
  bool terminal_;
  int shown_ = -1;
};

}  // namespace vir::app
