#include "vir/check/range_check.h"

#include <algorithm>
#include <cmath>

#include "text.h"
#include "vir/core/order_statistics.h"

namespace vir::check {
namespace {

constexpr double kNoisy = 6, kNoisyM = 0.3;  // times what is given, and [m], to say a word

constexpr std::size_t kKept = 5000;    // values per anchor
constexpr std::size_t kAnchors = 256;  // more are bit errors
constexpr double kFastest = 60;        // [m/s] of what carries a radio
constexpr double kFarthest = 300;      // [m] that such a radio reaches

double medianOfAll(const std::map<std::uint64_t, std::vector<double>>& lists) {
  std::vector<double> all;
  for (const auto& [id, values] : lists) all.insert(all.end(), values.begin(), values.end());
  return medianInPlace(&all);
}

}  // namespace

void RangeCheck::add(const Range& r) {
  ++count_;
  sigma_m_ = r.sigma_m;
  if (!std::isfinite(r.range_m) || r.range_m <= 0) {
    ++not_positive_;
    return;
  }
  if (anchors_.count(r.anchor) == 0 && anchors_.size() >= kAnchors) {
    ++other_anchors_;
    return;
  }
  Anchor& a = anchors_[r.anchor];
  if (r.range_m == std::floor(r.range_m)) ++a.whole;
  if (a.count > 0 && r.range_m == a.last) ++a.stuck;
  const double dt = toSeconds(r.t - a.last_t);
  if (a.values.size() < kKept) {
    a.values.push_back(r.range_m);
    if (a.count > 0 && dt > 0) a.speeds.push_back(std::abs(r.range_m - a.last) / dt);
    if (a.count > 1) a.bends.push_back(std::abs(r.range_m - 2 * a.last + a.before));
  }
  a.before = a.last;
  a.last = r.range_m;
  a.last_t = r.t;
  ++a.count;
}

void RangeCheck::checkUnit(std::vector<Finding>* out) const {
  std::map<std::uint64_t, std::vector<double>> values, speeds;
  long whole = 0, all = 0;
  for (const auto& [id, a] : anchors_) {
    values[id] = a.values;
    speeds[id] = a.speeds;
    whole += a.whole;
    all += a.count;
  }
  const double typical = medianOfAll(values), speed = medianOfAll(speeds);
  const bool integers = all > 20 && whole > all * 9 / 10;
  if (typical < kFarthest && !(integers && speed > kFastest)) return;
  const bool mm = typical > 1000 || speed > 100 * kFastest;
  out->push_back(
      {Severity::unusable, mm ? "ranges_in_mm" : "ranges_in_cm", label_,
       std::string("the ranges are in ") + (mm ? "millimetres" : "centimetres") + ", not in metres",
       "median " + num(typical, 4) + ", changing by " + num(speed) + " per second" +
           (integers ? ", all whole numbers" : ""),
       std::string("import with --set euroc.range_unit=") + (mm ? "mm" : "cm") +
           " (csv.range_unit for tables, unit=" + (mm ? "mm" : "cm") +
           " in --topic range= of a bag), or multiply them by " + (mm ? "0.001" : "0.01")});
}

std::vector<Finding> RangeCheck::findings() const {
  std::vector<Finding> out;
  if (count_ == 0) return out;
  if (not_positive_ > count_ / 10) {
    out.push_back({not_positive_ == count_ ? Severity::unusable : Severity::doubtful,
                   "ranges_not_positive", label_, "ranges are zero, negative or no numbers",
                   std::to_string(not_positive_) + " of " + std::to_string(count_),
                   "leave out what the radio reports as failed"});
  }
  checkUnit(&out);
  const bool units = worst(out) != Severity::unusable;
  long few = other_anchors_;
  for (const auto& [id, a] : anchors_) {
    if (a.count * 1000 < count_) few += a.count;
  }
  if (few > 0) {
    out.push_back({Severity::note, "rare_anchors", label_, "some anchors answer hardly ever",
                   std::to_string(few) + " ranges of anchors with less than 0.1 % of them",
                   "bit errors of the radio; they are left out by the estimator"});
  }
  for (const auto& [id, a] : anchors_) {
    if (a.count < 50) continue;
    const std::string anchor = "anchor " + std::to_string(id);
    if (a.stuck > a.count / 2) {
      out.push_back({Severity::note, "ranges_repeat", label_, anchor + " mostly repeats its range",
                     std::to_string(a.stuck) + " of " + std::to_string(a.count), ""});
    }
    // A second difference of white noise has 6 times its variance; 0.6745: median to sigma.
    const double sigma = median(a.bends) / 0.6745 / std::sqrt(6.0);
    const bool far = units && sigma_m_ > 0 && sigma > kNoisy * sigma_m_ && sigma > kNoisyM;
    out.push_back({far ? Severity::doubtful : Severity::note, "range_noise", label_,
                   anchor + (far ? ": far noisier than given" : ": noise as seen"),
                   num(sigma) + " m; given " + num(sigma_m_) + " m, median range " +
                       num(median(a.values)) + " m",
                   far ? "several antennas, tags or anchors under one id? else give the noise "
                         "(range_sigma_m)"
                       : ""});
  }
  return out;
}

}  // namespace vir::check
