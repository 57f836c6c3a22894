/// Can the result of a run be trusted?
#include <algorithm>
#include <cstdio>

#include "vir/results/run_recorder.h"

namespace vir::results {
namespace {

/// The first pose is expected within this time, and poses for at least this share of the frames
/// after it.
constexpr double kLateStartS = 8, kShareOfPoses = 0.9, kLostShare = 0.3;

std::string text(const char* pattern, double a, double b) {
  char out[160];
  std::snprintf(out, sizeof out, pattern, a, b);
  return out;
}

bool contains(const std::vector<std::string>& lines, const std::string& line) {
  return std::find(lines.begin(), lines.end(), line) != lines.end();
}

/// So much of a sensor's data can be left out without a doubt.
constexpr double kShareLeftOut = 0.2;

/// Counters of a kind of data.
struct Stream {
  std::string what;                  ///< as in RunSummary::left_out
  std::vector<std::string> given;    ///< add up to all that the estimator was given
  std::vector<std::string> useless;  ///< of these
};

std::vector<Stream> streams() {
  return {
      {kImages,
       {"images", "images_without_calibration"},
       {"images_unusable", "images_out_of_order", "images_without_imu", "images_misstamped",
        "images_without_calibration"}},
      {kImuReadings,
       {"imu_readings", "imu_not_finite", "imu_out_of_order", "imu_spikes", "imu_impossible",
        "imu_incomplete"},
       {"imu_not_finite", "imu_out_of_order", "imu_spikes", "imu_impossible", "imu_incomplete"}},
      {kOdometryPoses, {"odometry_poses"}, {"odometry_not_finite", "odometry_out_of_order"}},
      {kRanges, {}, {}}};
}

/// A device that was silent may not have counted what the robot did; one that jumped has not.
void doubtBrokenOdometry(RunSummary* s) {
  for (const auto& [name, count] : s->counters) {
    if (count == 0) continue;
    const std::string times = "(" + std::to_string(count) + ")";
    if (name == "odometry_gaps") {
      s->doubts.push_back("the odometry paused " + times +
                          ": what the robot did meanwhile is known by ranges alone");
    } else if (name == "odometry_jumps") {
      s->doubts.push_back("the odometry jumped " + times +
                          ": what lies before and behind is tied by ranges alone");
    }
  }
}

/// What much of could not be used may have given a path all the same.
void doubtLosses(RunSummary* s) {
  std::map<std::string, long> counted;
  for (const auto& [name, count] : s->counters) counted[name] = count;
  const auto sum = [&](const std::vector<std::string>& names) {
    long n = 0;
    for (const std::string& name : names) n += counted[name];
    return n;
  };
  for (const Stream& stream : streams()) {
    const auto before = s->left_out.find(stream.what);
    const long never_given = before == s->left_out.end() ? 0 : before->second;
    const long left_out = never_given + sum(stream.useless);
    long all = never_given + sum(stream.given);
    if (stream.what == kRanges) {
      all += s->ranges_accepted + s->ranges_collected + s->ranges_rejected + s->ranges_before_start;
    }
    const double share = all > 0 ? static_cast<double>(left_out) / static_cast<double>(all) : 0;
    if (share <= kShareLeftOut) continue;
    s->doubts.push_back(std::to_string(left_out) + " of " + std::to_string(all) + " " +
                        stream.what +
                        " could not be used (the counters and warnings of the summary say why)");
  }
}

/// The doubts that only a whole run can raise, and the verdict.
void decideVerdict(RunSummary* s) {
  const double share =
      s->frames > 0 ? static_cast<double>(s->poses) / static_cast<double>(s->frames) : 0;
  if (!s->error.empty()) s->doubts.push_back("the run ended early: " + s->error);
  if (s->poses == 0) {
    std::string why =
        s->longest_wait_reason.empty() ? "nothing to start from" : s->longest_wait_reason;
    s->doubts.push_back("no pose at all: " + why + "; `vir-slam check` looks at the recording");
    s->verdict = Verdict::lost;
    return;
  }
  if (s->init_time_s && *s->init_time_s > kLateStartS) {
    s->doubts.push_back(
        text("no pose in the first %.1f s of %.1f s", *s->init_time_s, s->duration_s) +
        (s->longest_wait_reason.empty() ? "" : ": " + s->longest_wait_reason));
  }
  const double from_start =
      s->duration_s > 0 && s->init_time_s ? 1 - *s->init_time_s / s->duration_s : 1;
  if (from_start > 0 && share / from_start < kShareOfPoses) {
    s->doubts.push_back(text("poses for %.0f %% of the images after the first pose only (%.0f)",
                             100 * share / from_start, static_cast<double>(s->poses)));
  }
  doubtLosses(s);
  doubtBrokenOdometry(s);
  s->verdict = s->doubts.empty()    ? Verdict::good
               : share < kLostShare ? Verdict::lost
                                    : Verdict::doubtful;
}

}  // namespace

const char* name(Verdict verdict) {
  switch (verdict) {
    case Verdict::good:
      return "good";
    case Verdict::doubtful:
      return "doubtful";
    case Verdict::lost:
      return "lost";
  }
  return "lost";
}

void fillVerdict(RunSummary* s, const std::function<std::vector<std::string>()>& explain) {
  s->doubts.insert(s->doubts.begin(), s->unusable_input.begin(), s->unusable_input.end());
  decideVerdict(s);
  if (s->verdict == Verdict::good) return;
  // What the input itself shows explains the rest.
  std::vector<std::string> causes;
  const auto add = [&](const std::vector<std::string>& lines) {
    for (const std::string& line : lines) {
      if (!contains(causes, line) && !contains(s->unusable_input, line)) causes.push_back(line);
    }
  };
  if (explain) add(explain());
  add(s->likely_causes);
  s->likely_causes = causes;
  s->doubts.insert(s->doubts.begin(), causes.begin(), causes.end());
}

}  // namespace vir::results
