#pragma once
/// The clock of a program that a test runs (clock/settable_clock.cpp). Not with sanitizers, which
/// want to be loaded first.
#include <cmath>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>

#include "vir_test_paths.h"

namespace vir::test {

class SettableClock {
 public:
  /// `file`: to be made.
  explicit SettableClock(std::string file) : file_(std::move(file)) { write(); }
  /// By how much the wall clock is off from now on, in all [s].
  void setBy(double s) {
    shift_[0] = std::llround(s * 1e9);
    write();
  }
  /// The machine has slept so long, in all [s]: the monotonic clock stood meanwhile.
  void sleptFor(double s) {
    shift_[1] = std::llround(s * 1e9);
    write();
  }
  const std::string& file() const { return file_; }
  static std::string library() { return buildDir() + "/lib/libvir_test_clock.so"; }
  /// Before a command of a shell, which then has this clock.
  std::string prefix() const {
    return "LD_PRELOAD='" + library() + "' VIR_TEST_CLOCK='" + file_ + "' ";
  }

 private:
  void write() const {
    // In place: the program has it mapped.
    std::fstream out(file_, std::ios::binary | std::ios::in | std::ios::out);
    if (!out) out.open(file_, std::ios::binary | std::ios::out);
    out.write(reinterpret_cast<const char*>(shift_), sizeof shift_);
    if (!out.flush()) throw std::runtime_error(file_ + ": cannot be written");
  }
  std::string file_;
  std::int64_t shift_[2] = {0, 0};
};

}  // namespace vir::test
