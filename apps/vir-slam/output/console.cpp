#include "output/console.h"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>

namespace vir::app {
namespace {

constexpr int kBarWidth = 40;
volatile std::sig_atomic_t interrupt_seen = 0;

void onInterrupt(int signal) {
  interrupt_seen = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

ProgressBar::ProgressBar() : terminal_(isatty(STDERR_FILENO) == 1) {}

void ProgressBar::show(double part) {
  const int percent = static_cast<int>(100 * std::clamp(part, 0.0, 1.0));
  if (!terminal_ || percent == shown_) return;
  shown_ = percent;
  const int filled = percent * kBarWidth / 100;
  const std::string bar = std::string(filled, '#') + std::string(kBarWidth - filled, '.');
  std::fprintf(stderr, "\r[%s] %3d %%", bar.c_str(), percent);
  std::fflush(stderr);
}

void ProgressBar::clear() {
  if (!terminal_ || shown_ < 0) return;
  std::fprintf(stderr, "\r\033[K");
  std::fflush(stderr);
  shown_ = -1;
}

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

const char* levelName(LogLevel level) {
  switch (level) {
    case LogLevel::debug:
      return "debug";
    case LogLevel::info:
      return "info";
    case LogLevel::warning:
      return "warning";
    case LogLevel::error:
      break;
  }
  return "error";
}

std::string printable(const std::string& text) {
  constexpr std::size_t kMost = 1000;
  std::string out = text.substr(0, kMost);
  for (char& c : out) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  }
  return text.size() > kMost ? out + "..." : out;
}

std::string fixed(double v, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, v);
  return text;
}

void catchInterrupt() {
  interrupt_seen = 0;
  std::signal(SIGINT, onInterrupt);
  std::signal(SIGTERM, onInterrupt);
}

bool interrupted() { return interrupt_seen != 0; }

}  // namespace vir::app
