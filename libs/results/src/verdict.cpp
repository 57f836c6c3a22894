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
