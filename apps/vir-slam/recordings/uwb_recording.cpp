#include "recordings/uwb_recording.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "commands/commands.h"
#include "output/console.h"
#include "vir/core/parse_number.h"
#include "vir/core/text_file.h"
#include "vir/evaluation/leaps.h"
#include "vir/ranging/anchor_initialization.h"
#include "vir/ranging/survey_table.h"
#include "vir/rawlog/convert.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/rawlog_reader.h"
#include "vir/types/interpolation.h"

namespace vir::app {
namespace {

/// An anchor is looked for in so many ranges, of a board as it comes [m] with such noise [m]; known
/// so well it will do [m]; and so far off, in metres and in sigmas, it is not where it is said to
/// be.
constexpr int kFewest = 50;
constexpr double kUncalibrated = 0.7, kRangeSigma = 0.1;
constexpr double kKnown = 0.15, kElsewhere = 0.5, kElsewhereSigmas = 5;
constexpr std::size_t kLargest = 4'000'000;  // [byte]
constexpr TimeNs kMaxGap = 100'000'000;      // the ground truth is not interpolated across more

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> fields;
  std::istringstream in(text);
  for (std::string field; std::getline(in, field, ',');) {
    const auto first = field.find_first_not_of(" \t\r");
    const auto last = field.find_last_not_of(" \t\r");
    fields.push_back(first == std::string::npos ? "" : field.substr(first, last - first + 1));
  }
  return fields;
}

/// Ids as tables of anchors have them: 132, 132.0 or 0x84.
bool wholeNumber(const std::string& text, int* value) {
  if (text.rfind("0x", 0) == 0 || text.rfind("0X", 0) == 0) {
    return parseNumber(text.substr(2), value, 16);
  }
  double v = 0;
  if (!parseFinite(text, &v) || v != std::floor(v) || std::abs(v) > 2e9) return false;
  *value = static_cast<int>(v);
  return true;
}

/// Empty, or what is wrong with the fields.
std::string takeAnchor(const std::vector<std::string>& fields, AnchorPositions* anchors) {
  if (fields.size() < 4) return "expected id,x,y,z";
  int id = 0;
  if (!wholeNumber(fields[0], &id)) return "the id '" + fields[0] + "' is no whole number";
  Vec3 p;
  for (int k = 0; k < 3; ++k) {
    const std::string& field = fields[static_cast<std::size_t>(k) + 1];
    if (!parseFinite(field, &p[k])) return "'" + field + "' is no finite number";
  }
  if (!anchors->emplace(id, p).second) {
    return "anchor " + fields[0] + " is there already";
  }
  return {};
}

void read(rawlog::RawlogReader* reader, Trajectory* truth, std::vector<Range>* ranges) {
  ProgressBar bar;
  while (const auto observation = reader->next()) {
    if (interrupted()) throw std::runtime_error("interrupted; nothing has been written");
    bar.show(reader->progress());
    const std::string& label = observation->sensorLabel;
    if (const auto pose = rawlog::poseOf(*observation);
        pose && label == rawlog::kGroundTruthLabel) {
      truth->push_back(*pose);
    }
    if (label == rawlog::kPeerLabel) continue;
    for (const Range& r : rawlog::rangesOf(*observation)) ranges->push_back(r);
  }
  const auto earlier = [](const auto& a, const auto& b) { return a.t < b.t; };
  std::stable_sort(truth->begin(), truth->end(), earlier);
  truth->erase(std::unique(truth->begin(), truth->end(),
                           [](const StampedPose& a, const StampedPose& b) { return a.t == b.t; }),
               truth->end());
  std::stable_sort(ranges->begin(), ranges->end(), earlier);
}

void addCounters(const ranging::RangeCheckCounters& from, ranging::RangeCheckCounters* to) {
  to->ok += from.ok;
  for (const auto& [problem, count] : from.problems) to->problems[problem] += count;
  to->clock_restarts += from.clock_restarts;
}

/// Where the ranges of one anchor put it, the path being true.
std::optional<ranging::AnchorSolution> whereRangesPut(
    const std::vector<ranging::AntennaRange>& ranges) {
  ranging::AnchorInitOptions options;
  options.min_ranges = kFewest;
  options.bias_sigma_m = kUncalibrated;
  options.drift_ratio = options.scale_sigma = options.floor_sigma_m = 0;
  const ranging::AnchorInitialization found = ranging::initializeAnchor(ranges, options);
  if (found.geometry != ranging::AnchorGeometry::good) return std::nullopt;
  return found.solutions.front();
}

/// The longest axis [m].
double sigmaOf(const ranging::AnchorSolution& s) {
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(s.covariance.topLeftCorner<3, 3>());
  return std::sqrt(std::max(0.0, eigen.eigenvalues()[2]));
}

std::string text(const Vec3& p) {
  return "(" + fixed(p.x(), 2) + " " + fixed(p.y(), 2) + " " + fixed(p.z(), 2) + ")";
}

}  // namespace

void addAnchor(const std::string& text, AnchorPositions* anchors) {
  const std::vector<std::string> fields = split(text);
  std::string problem = fields.size() > 4 ? "expected id,x,y,z" : takeAnchor(fields, anchors);
  if (!problem.empty()) throw UsageError("--anchor " + text + ": " + problem);
}

void addAnchorFile(const std::string& path, AnchorPositions* anchors) {
  requireFile(path, "file of anchors");
  try {
    for (const SurveyedAnchor& a : ranging::surveyFromText(readTextFile(path, kLargest), path)) {
      if (anchors->emplace(static_cast<int>(a.id), a.p_S).second) continue;
      throw UsageError(path + ": anchor " + std::to_string(a.id) + " is there already");
    }
  } catch (const std::runtime_error& e) {
    throw UsageError(e.what());
  }
}

void addRecording(const std::string& rawlog, UwbSamples* out) {
  rawlog::RawlogReader reader(rawlog);
  Trajectory truth;
  std::vector<Range> ranges;
  read(&reader, &truth, &ranges);
  if (!reader.damage().empty()) out->damage.push_back(reader.damage());
  if (truth.empty()) {
    throw std::runtime_error(rawlog + " holds no ground truth (poses with the label GT)");
  }
  if (ranges.empty()) throw std::runtime_error(rawlog + " holds no ranges to anchors");

  long left_out = 0;
  truth = evaluation::withoutLeaps(truth, &left_out);
  if (left_out > 0) out->notes.push_back(rawlog + ": " + evaluation::describeLeaps(left_out));
  ranging::RangeCheck check;
  std::map<int, int> series;  // of this recording
  const int first_series = out->seen.empty() ? 0 : out->seen.back().series + 1000;
  for (const Range& r : ranges) {
    ++out->ranges;
    const int id = static_cast<int>(r.anchor);  // as the radio says it
    if (check.check(id, r.t, r.range_m) != RangeDecision::accepted) continue;
    const std::optional<Pose> pose = poseAt(truth, r.t, kMaxGap);
    if (!pose) {
      ++out->without_truth;
      continue;
    }
    const int of_series =
        series.emplace(id, first_series + static_cast<int>(series.size())).first->second;
    out->seen.push_back({r.t, id, of_series, *pose * r.p_B_U, r.range_m});
  }
  addCounters(check.counters(), &out->checks);
}

void fillSamples(AnchorPositions anchors, UwbSamples* out) {
  std::map<int, std::vector<ranging::AntennaRange>> of_anchor;
  for (const TrueRange& s : out->seen) {
    of_anchor[s.anchor].push_back({s.antenna, s.range_m, kRangeSigma});
  }
  for (const auto& [id, ranges] : of_anchor) {
    const std::optional<ranging::AnchorSolution> found = whereRangesPut(ranges);
    const auto given = anchors.find(id);
    if (given == anchors.end() && found && sigmaOf(*found) < kKnown) {
      anchors[id] = found->p_W;
      out->notes.push_back("the position of anchor " + std::to_string(id) +
                           " is not given: its ranges put it at " + text(found->p_W) + " m, +- " +
                           fixed(sigmaOf(*found), 2) + " m");
    } else if (given != anchors.end() && found) {
      const double off = (found->p_W - given->second).norm();
      if (off < kElsewhere || off < kElsewhereSigmas * sigmaOf(*found)) continue;
      throw std::runtime_error("anchor " + std::to_string(id) + " is given at " +
                               text(given->second) + " m, but its ranges put it at " +
                               text(found->p_W) + " m, " + fixed(off, 2) +
                               " m from there: a calibration would be wrong");
    }
  }
  for (const TrueRange& s : out->seen) {
    const auto anchor = anchors.find(s.anchor);
    if (anchor == anchors.end()) {
      ++out->unknown_anchor[s.anchor];
      continue;
    }
    const double distance = (anchor->second - s.antenna).norm();
    out->samples.push_back({s.t, s.series, distance, s.range_m - distance});
    out->anchor.push_back(s.anchor);
  }
}

}  // namespace vir::app
