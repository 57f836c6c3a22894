#include "vir/check/stream_check.h"

#include <algorithm>
#include <cmath>

#include "text.h"
#include "vir/core/order_statistics.h"
#include "vir/core/time_bounds.h"

namespace vir::check {
namespace {

/// Of images, whose rate may vary with the light [s].
constexpr double kImageJitter = 0.005;
constexpr std::size_t kPeriods = 20000;
constexpr std::size_t kRateBlock = 50, kMostChanges = 100;
constexpr double kOtherRate = 1.3, kSameRate = 1.1;       // times
constexpr TimeNs kUnixSince = 1'000'000'000'000'000'000;  // 2001, in ns

/// Share of the images that readings must cover.
constexpr double kImagesCovered = 0.9;
/// Below, an IMU says little between images [Hz].
constexpr double kSlowImu = 50, kTooSlowImu = 30;

/// Rates that a sensor of a kind can have [Hz].
struct Rates {
  double least, most;
};

Rates ratesOf(StreamKind kind) {
  switch (kind) {
    case StreamKind::images:
      return {0.2, 2000};
    case StreamKind::imu:
      return {10, 50000};
    case StreamKind::ranges:
    case StreamKind::poses:
      return {0.001, 50000};
    case StreamKind::other:
      break;
  }
  return {0, 1e12};
}

/// What nanoseconds are that are something else.
struct WrongUnit {
  const char* kind;
  const char* unit;
  double factor;  ///< by which the rate is too high
};
constexpr WrongUnit kWrongUnits[] = {{"stamps_in_us", "microseconds", 1e3},
                                     {"stamps_in_ms", "milliseconds", 1e6},
                                     {"stamps_in_s", "seconds", 1e9}};

/// Longest hole [s] that is nothing to worry about.
double harmlessGap(const StreamSummary& s) {
  const double period = s.rate_hz > 0 ? 1 / s.rate_hz : 0;
  if (s.kind == StreamKind::imu) return std::max(0.1, 10 * period);
  return std::max(1.0, 10 * period);
}

std::string span(const StreamSummary& s) {
  char text[96];
  std::snprintf(text, sizeof text, "%s from %.3f to %.3f s", s.label.c_str(), toSeconds(s.first),
                toSeconds(s.last));
  return text;
}

bool checkRate(const StreamSummary& s, std::vector<Finding>* out) {
  const Rates rates = ratesOf(s.kind);
  if (s.count < 3 || (s.rate_hz >= rates.least && s.rate_hz <= rates.most)) return true;
  Finding f{Severity::unusable, "rate", s.label, "", num(s.rate_hz, 6) + " Hz", ""};
  f.what = "cannot come at this rate: the stamps are in another unit, or not what they should be";
  f.remedy = "stamps must be nanoseconds, microseconds, milliseconds or seconds of one clock";
  // Over the whole span the rate is what it should be: it is the stamps that come in bursts.
  const double mean_hz =
      static_cast<double>(s.count - 1) / std::max(1e-9, toSeconds(s.last - s.first));
  if (s.rate_hz > rates.most && mean_hz >= rates.least && mean_hz <= rates.most) {
    f.kind = "bursts";
    f.what = "stamps come in bursts";
    f.evidence = num(mean_hz) + " Hz in the mean, " + num(s.rate_hz, 6) + " Hz within a burst";
    f.remedy = "stamp each when it is measured, not when a batch is read";
    out->push_back(f);
    return false;
  }
  // Typical of a camera and an IMU, to tell the unit by.
  const double typical = s.kind == StreamKind::imu ? 200 : 20;
  for (const WrongUnit& u : kWrongUnits) {
    if (std::abs(std::log(s.rate_hz / u.factor / typical)) > std::log(20.0)) continue;
    f.kind = u.kind;
    f.what = std::string("the stamps are in ") + u.unit + ", taken for nanoseconds";
    f.remedy = "import again with stamps in nanoseconds";
    break;
  }
  out->push_back(f);
  return false;
}

/// `further`: a camera beside the first.
void checkOrder(const StreamSummary& s, bool further, std::vector<Finding>* out) {
  const double share = static_cast<double>(s.out_of_order) / static_cast<double>(s.count);
  if (s.out_of_order > 0) {
    out->push_back(
        {share > 0.01 ? Severity::doubtful : Severity::note, "order", s.label, "stamps go back",
         std::to_string(s.out_of_order) + " of " + std::to_string(s.count), "sort it by stamp"});
  }
  if (s.repeated > s.count / 100 && s.kind != StreamKind::ranges) {
    out->push_back({Severity::doubtful, "repeated", s.label, "stamps repeat",
                    std::to_string(s.repeated) + " of " + std::to_string(s.count),
                    "stamp each when it is measured, not when a batch is read"});
  }
  if (s.longest_gap_s > harmlessGap(s) && s.kind != StreamKind::poses) {
    out->push_back({Severity::doubtful, "gap", s.label, "has a gap",
                    "nothing for " + num(s.longest_gap_s) + " s at " + num(s.rate_hz) + " Hz",
                    s.kind == StreamKind::imu
                        ? "the images bridge up to 4 s; beyond, a run begins a new segment"
                    : further ? "what lies in it is lost; a run has the other cameras meanwhile"
                    : s.kind == StreamKind::ranges
                        ? "what lies in it is lost; the path goes on without ranges meanwhile"
                        : "what lies in it is lost; the readings of the IMU carry on meanwhile"});
  }
  const double period = s.rate_hz > 0 ? 1 / s.rate_hz : 0;
  // That of a camera may follow the light.
  const bool changes = s.kind == StreamKind::imu && !s.rate_changes.empty();
  if (changes) {
    const RateChange& first = s.rate_changes[0];
    const std::size_t more = s.rate_changes.size() - 1;
    out->push_back({Severity::doubtful, "rate_changes", s.label,
                    "its rate changes from " + num(first.from_hz) + " to " + num(first.to_hz) +
                        " Hz, " + num(toSeconds(first.at - s.first), 4) + " s after its beginning",
                    more == 0 ? "and stays so" : "and " + std::to_string(more) + " times more",
                    "set the rate before the recording begins; else look for readings that are "
                    "lost on the way"});
  }
  if (s.kind == StreamKind::imu && !changes && period > 0 && s.jitter_s > 0.25 * period) {
    out->push_back({Severity::doubtful, "jitter", s.label, "stamps jitter",
                    "period " + num(1e3 * period) + " ms, off by " + num(1e3 * s.jitter_s) +
                        " ms in the median",
                    "use the sensor's own stamps, not those of arrival"});
  }
  if (s.kind == StreamKind::images && s.jitter_s > std::max(kImageJitter, 0.15 * period)) {
    out->push_back({Severity::doubtful, "jitter", s.label, "stamps jitter",
                    "period " + num(1e3 * period) + " ms, off by " + num(1e3 * s.jitter_s) +
                        " ms in the median",
                    "use the camera's own stamps (exposure), not those of arrival"});
  }
  if (s.kind == StreamKind::imu && s.count > 2 && s.rate_hz < kSlowImu) {
    out->push_back({s.rate_hz < kTooSlowImu ? Severity::doubtful : Severity::note, "slow_imu",
                    s.label, "is slow for an IMU", num(s.rate_hz) + " Hz",
                    "100 Hz or more is better"});
  }
}

/// How the two clocks may have come apart.
std::string whyApart(const StreamSummary& a, const StreamSummary& b) {
  const bool unix_a = a.first >= kUnixSince, unix_b = b.first >= kUnixSince;
  if (unix_a == unix_b) return "the two are from different clocks";
  const std::string& up = unix_a ? b.label : a.label;
  const std::string& date = unix_a ? a.label : b.label;
  return up + " counts from power-up, " + date + " is Unix time";
}

TimeNs inCommon(const StreamSummary& a, const StreamSummary& b) {
  return std::min(a.last, b.last) - std::max(a.first, b.first);
}

/// `imu_alone`: no camera has its clock.
std::string remedyApart(const StreamSummary& imu, const StreamSummary& other, bool imu_alone) {
  const bool images = other.kind == StreamKind::images;
  if (images ? !imu_alone : other.kind != StreamKind::ranges) {
    return "put both on one clock before importing";
  }
  const TimeNs later = timeBetween(imu.first, other.first);
  return "import with --set " + std::string(kDriver) +
         (images ? ".imu_time_offset_s=" : ".range_time_offset_s=") +
         num(toSeconds(images ? later : -later), 12) +
         " if both began together (images to 0.1 s); the messages of a bag may have been received "
         "by one clock: stamps=received";
}

void checkOverlap(const StreamSummary& imu, const StreamSummary& other, bool imu_alone,
                  std::vector<Finding>* out) {
  const TimeNs both = inCommon(imu, other);
  // Images that have no readings give no poses; of the others a part may do.
  const bool images = other.kind == StreamKind::images;
  const TimeNs of_both = std::min(imu.last - imu.first, other.last - other.first);
  const TimeNs wanted = images ? other.last - other.first : of_both;
  const double least = images ? kImagesCovered : 0.5;
  const std::string spans = span(imu) + ", " + span(other);
  if (both <= 0) {
    out->push_back({images ? Severity::unusable : Severity::doubtful, "no_overlap", other.label,
                    "has no time in common with " + imu.label + ": " + whyApart(imu, other), spans,
                    remedyApart(imu, other, imu_alone)});
  } else if (toSeconds(both) < least * toSeconds(wanted)) {
    out->push_back({Severity::doubtful, "little_overlap", other.label,
                    "overlaps with " + imu.label + " for " + num(toSeconds(both)) + " of " +
                        num(toSeconds(wanted)) + " s only",
                    spans, "check that both are from one recording and one clock, and whole"});
  }
}

}  // namespace

StreamCheck::StreamCheck(std::string label, StreamKind kind) {
  s_.label = std::move(label);
  s_.kind = kind;
}

void StreamCheck::add(TimeNs t) {
  if (s_.count++ == 0) {
    s_.first = s_.last = newest_ = t;
    return;
  }
  s_.first = std::min(s_.first, t);
  s_.last = std::max(s_.last, t);
  if (t < newest_) {
    ++s_.out_of_order;
  } else if (t == newest_) {
    ++s_.repeated;
  } else {
    s_.longest_gap_s = std::max(s_.longest_gap_s, toSeconds(t - newest_));
    if (periods_.size() < kPeriods) periods_.push_back(t - newest_);
    followRate(t, t - newest_);
  }
  newest_ = std::max(newest_, t);
}

/// A rate counts once two blocks in a row have it: one alone is a hole or a burst.
void StreamCheck::followRate(TimeNs t, TimeNs period) {
  if (latest_.empty()) block_start_ = t - period;
  latest_.push_back(period);
  if (latest_.size() < kRateBlock) return;
  const TimeNs median = medianInPlace(&latest_);
  latest_.clear();
  const auto apart = [median](TimeNs other) {
    const double ratio = static_cast<double>(median) / static_cast<double>(other);
    return std::max(ratio, 1 / ratio);
  };
  if (usual_ == 0) usual_ = median;
  if (apart(usual_) < kOtherRate) {
    other_ = 0;
  } else if (other_ != 0 && apart(other_) < kSameRate) {
    if (s_.rate_changes.size() < kMostChanges) {
      s_.rate_changes.push_back({other_since_, 1 / toSeconds(usual_), 1 / toSeconds(median)});
    }
    usual_ = median;
    other_ = 0;
  } else {
    other_ = median;
    other_since_ = block_start_;
  }
}

StreamSummary StreamCheck::summary() const {
  StreamSummary out = s_;
  std::vector<TimeNs> periods = periods_;
  const TimeNs period = medianInPlace(&periods);
  if (period <= 0) return out;
  out.rate_hz = 1 / toSeconds(period);
  for (TimeNs& p : periods) p = std::abs(p - period);
  out.jitter_s = toSeconds(medianInPlace(&periods));
  return out;
}

std::vector<Finding> checkStreams(const std::vector<StreamSummary>& streams) {
  std::vector<Finding> out;
  const StreamSummary* imu = nullptr;
  const StreamSummary* first_camera = nullptr;
  std::vector<const StreamSummary*> sound;  // whose stamps can be those of one clock
  for (const StreamSummary& s : streams) {
    if (s.count == 0) continue;
    if (s.kind == StreamKind::imu && imu == nullptr) imu = &s;
    if (s.kind == StreamKind::images && first_camera == nullptr) first_camera = &s;
    if (!checkRate(s, &out)) continue;
    checkOrder(s, s.kind == StreamKind::images && &s != first_camera, &out);
    sound.push_back(&s);
  }
  if (std::none_of(streams.begin(), streams.end(),
                   [](const StreamSummary& s) { return s.count > 0; })) {
    out.push_back({Severity::unusable, "empty", "recording", "there is nothing in it that is known",
                   "", "look whether it is the right file, and whether its recording ended well"});
    return out;
  }
  const bool images = std::any_of(streams.begin(), streams.end(), [](const StreamSummary& s) {
    return s.kind == StreamKind::images && s.count > 0;
  });
  if (images && imu == nullptr) {
    out.push_back({Severity::unusable, "no_imu", "IMU", "there is none", "",
                   "a camera alone knows no scale: record or import the IMU as well"});
  }
  if (std::find(sound.begin(), sound.end(), imu) == sound.end()) return out;
  const bool imu_alone = std::none_of(sound.begin(), sound.end(), [&](const StreamSummary* s) {
    return s->kind == StreamKind::images && inCommon(*imu, *s) > 0;
  });
  for (const StreamSummary* s : sound) {
    if (s != imu && s->count > 1) checkOverlap(*imu, *s, imu_alone, &out);
  }
  return out;
}

}  // namespace vir::check
