#include "vir/imu/saturation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace vir::imu {
namespace {

/// No sensor has a smaller range: 125 deg/s, 2 g [rad/s], [m/s^2].
constexpr double kLeastRate = 2.1, kLeastAcceleration = 19;

}  // namespace

bool SaturationCounter::add(End* end, double value, double least, TimeNs t) const {
  const double size = std::abs(value);
  if (size < least || size < end->limit) {
    end->run = 0;
    return false;
  }
  if (size > end->limit) *end = {size, t, 0, 0, 0};  // the range is larger than it seemed
  if (end->run++ == 0) end->first = t;
  if (end->run < kFewest) return false;
  end->readings += end->run == kFewest ? kFewest : 1;
  end->longest = std::max(end->longest, t - end->first);
  return true;
}

std::optional<TimeNs> SaturationCounter::add(const ImuSample& s) {
  if (!s.gyro.allFinite() || !s.acc.allFinite() || (any_ && s.t <= last_.t)) return std::nullopt;
  const bool repeated = any_ && s.gyro == last_.gyro && s.acc == last_.acc;
  last_ = s;
  any_ = true;
  if (repeated) return std::nullopt;
  std::optional<TimeNs> begin;
  for (int i = 0; i < 6; ++i) {
    const double value = i < 3 ? s.gyro[i] : s.acc[i - 3];
    const double least = i < 3 ? kLeastRate : kLeastAcceleration;
    auto& ends = ends_[static_cast<std::size_t>(i)];
    End& end = ends[value > 0 ? 1 : 0];
    if (add(&end, value, least, s.t)) begin = std::min(begin.value_or(end.first), end.first);
    ends[value > 0 ? 0 : 1].run = 0;
  }
  return begin;
}

long SaturationCounter::readings() const {
  long n = 0;
  for (const auto& ends : ends_) n += ends[0].readings + ends[1].readings;
  return n;
}

const SaturationCounter::End* SaturationCounter::worst() const {
  const End* out = nullptr;
  for (const auto& ends : ends_) {
    for (const End& e : ends) {
      if (e.readings > 0 && (out == nullptr || e.longest > out->longest)) out = &e;
    }
  }
  return out;
}

double SaturationCounter::longestS() const {
  const End* end = worst();
  return end == nullptr ? 0 : toSeconds(end->longest);
}

std::string SaturationCounter::where() const {
  const End* end = worst();
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    for (const End& e : ends_[i]) {
      if (&e != end) continue;
      char text[64];
      std::snprintf(text, sizeof text, "%s %c at %.4g %s", i < 3 ? "gyro" : "accelerometer",
                    "xyz"[i % 3], e.limit, i < 3 ? "rad/s" : "m/s^2");
      return text;
    }
  }
  return "";
}

}  // namespace vir::imu
