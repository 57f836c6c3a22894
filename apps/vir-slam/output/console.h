#pragma once
/// What the subcommands show on the terminal.
#include <string>
#include <vector>

#include "vir/core/log.h"

namespace vir::app {

/// One line on stderr that is redrawn; silent where stderr is no terminal.
class ProgressBar {
 public:
  ProgressBar();
  ~ProgressBar() { clear(); }
  /// `part` 0..1.
  void show(double part);
  /// Wipes the line, so that something else can be printed.
  void clear();

 private:
  bool terminal_ = false;
  int shown_ = -1;
};

struct TableRow {
  std::string metric, value, unit;
};

/// Metric | Value | Unit on stdout.
void printTable(const std::vector<TableRow>& rows);

/// What a line of this level begins with: debug, info, warning, error.
const char* levelName(LogLevel level);

/// `v` with `decimals` digits behind the point.
/// What files hold, for the terminal: control characters, which could change how it looks or what
/// it shows, as `?`, and no more than 1000 bytes.
std::string printable(const std::string& text);

std::string fixed(double v, int decimals);

/// From now on Ctrl-C or SIGTERM only sets what interrupted() tells; a second one ends the program.
void catchInterrupt();
bool interrupted();

}  // namespace vir::app
