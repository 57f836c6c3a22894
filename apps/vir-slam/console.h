#pragma once
/// What the subcommands show on the terminal.
#include <string>
#include <vector>

namespace vir::app {

struct TableRow {
  std::string metric, value, unit;
};

/// Metric | Value | Unit on stdout.
void printTable(const std::vector<TableRow>& rows);

/// `v` with `decimals` digits behind the point.
std::string fixed(double v, int decimals);

/// From now on Ctrl-C only sets what interrupted() tells; a second one ends the program.
void catchInterrupt();
bool interrupted();

}  // namespace vir::app
