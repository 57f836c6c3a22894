#include "console.h"

#include <algorithm>
#include <csignal>
#include <cstdio>

namespace vir::app {
namespace {

volatile std::sig_atomic_t interrupt_seen = 0;

void onInterrupt(int signal) {
  interrupt_seen = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void printTable(const std::vector<TableRow>& rows) {
  TableRow head{"Metric", "Value", "Unit"};
  std::size_t metric = head.metric.size();
  std::size_t value = head.value.size();
  for (const TableRow& row : rows) {
    metric = std::max(metric, row.metric.size());
    value = std::max(value, row.value.size());
  }
  const auto print = [&](const TableRow& row) {
    std::printf("%-*s | %*s | %s\n", static_cast<int>(metric), row.metric.c_str(),
                static_cast<int>(value), row.value.c_str(), row.unit.c_str());
  };
  print(head);
  std::printf("%s-+-%s-+-----\n", std::string(metric, '-').c_str(),
              std::string(value, '-').c_str());
  for (const TableRow& row : rows) print(row);
}

std::string fixed(double v, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, v);
  return text;
}

void catchInterrupt() {
  interrupt_seen = 0;
  std::signal(SIGINT, onInterrupt);
}

bool interrupted() { return interrupt_seen != 0; }

}  // namespace vir::app
