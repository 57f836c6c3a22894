#include "output/check_report.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

namespace vir::app {

void printStreams(const std::vector<check::StreamSummary>& streams) {
  std::printf("%-8s %10s %12s %10s %12s %14s\n", "label", "count", "rate [Hz]", "span [s]",
              "jitter [ms]", "longest gap [s]");
  for (const check::StreamSummary& s : streams) {
    std::printf("%-8s %10ld %12.2f %10.2f %12.3f %14.3f\n", s.label.c_str(), s.count, s.rate_hz,
                toSeconds(s.last - s.first), 1e3 * s.jitter_s, s.longest_gap_s);
  }
}

void printFindings(const std::vector<check::Finding>& findings) {
  for (const check::Finding& f : findings) {
    std::printf("\n%s: %s: %s\n", check::name(f.severity), f.stream.c_str(), f.what.c_str());
    if (!f.evidence.empty()) std::printf("  evidence: %s\n", f.evidence.c_str());
    if (!f.remedy.empty()) std::printf("  what to do: %s\n", f.remedy.c_str());
  }
}

namespace {

/// So many lines or messages that cannot be read are more than a slip.
constexpr long kManyUnreadable = 5;

/// More images than this share that cannot be decoded are more than a slip.
constexpr double kManyImages = 0.01;

constexpr const char* kMissing = "image_missing";

bool isOfImages(const std::string& counter) {
  return counter.find("image_undecodable") == 0 || counter.find("undecodable_CAM") == 0 ||
         counter == kMissing;
}

double imagesOf(const std::vector<check::StreamSummary>& streams) {
  double n = 0;
  for (const auto& s : streams) {
    if (s.kind == check::StreamKind::images) n += static_cast<double>(s.count);
  }
  return n;
}

/// Stamps that are too coarse make readings look alike.
std::optional<check::Finding> repeatedReadings(long repeated,
                                               const std::vector<check::StreamSummary>& streams) {
  const auto imu = std::find_if(streams.begin(), streams.end(),
                                [](const auto& s) { return s.kind == check::StreamKind::imu; });
  if (imu == streams.end() || 100 * repeated < imu->count) return std::nullopt;
  const long all = imu->count + repeated;
  char share[40], step[40];
  std::snprintf(share, sizeof share, "%.2g %%",
                100.0 * static_cast<double>(repeated) / static_cast<double>(all));
  std::snprintf(step, sizeof step, "%.4g ms", imu->rate_hz > 0 ? 1e3 / imu->rate_hz : 0.0);
  return check::Finding{check::Severity::doubtful,
                        "repeated",
                        imu->label,
                        std::string(share) +
                            " of its readings have the stamp of another one and "
                            "are not used",
                        std::to_string(repeated) + " of " + std::to_string(all) +
                            "; those left are " + step + " apart",
                        "write the stamps with all their digits (are they rounded to " +
                            std::string(step) + "?), or leave out readings that are there twice"};
}

}  // namespace

void addFindings(const SourceReport& source, const std::vector<check::StreamSummary>& streams,
                 std::vector<check::Finding>* findings) {
  if (source.damaged) {
    findings->push_back({check::Severity::doubtful, "damaged", "file",
                         "it is damaged or was cut off: there should be more", "",
                         "record it anew, or copy it again; what is there can be used"});
  }
  if (source.useless > 0) {
    findings->push_back({check::Severity::doubtful, "not_usable", "file",
                         "data of ranges or another stream are there, and none could be used", "",
                         "see the notes above; `import` fails for this reason"});
  }
  if (source.not_read > 0) {
    findings->push_back({check::Severity::doubtful, "not_read", "file",
                         "tables that are called after an IMU or ranges could not be read",
                         "tables: " + std::to_string(source.not_read), "see the notes above"});
  }
  if (source.by_position > 0) {
    findings->push_back({check::Severity::doubtful, "names_unknown", "file",
                         "names of columns are not known; they were taken by position",
                         "tables: " + std::to_string(source.by_position),
                         "see the notes above; give the columns known names"});
  }
  for (const auto& [counter, n] : source.unreadable) {
    const bool images = isOfImages(counter);
    if (n < kManyUnreadable && !images) continue;
    const bool slip = images && static_cast<double>(n) < kManyImages * imagesOf(streams);
    const bool missing = counter == kMissing;
    findings->push_back(
        {slip ? check::Severity::note : check::Severity::doubtful,
         missing ? "images_missing" : "unreadable", "file",
         images ? std::string(missing ? "images are listed and not there: "
                                      : "images cannot be decoded and are left out: ") +
                      std::to_string(n)
                : std::to_string(n) + " lines or messages are no readings and are left out",
         counter + " " + std::to_string(n), "see the notes above"});
  }
  if (source.too_late >= kManyUnreadable) {
    findings->push_back(
        {check::Severity::doubtful, "not_in_order", "file",
         "rows that come after later ones are left out: " + std::to_string(source.too_late), "",
         "sort the tables by their stamps; after a clock was set back begin a recording anew"});
  }
  if (const auto repeated = repeatedReadings(source.imu_repeated, streams)) {
    findings->push_back(*repeated);
  }
  std::stable_sort(findings->begin(), findings->end(),
                   [](const auto& a, const auto& b) { return a.severity > b.severity; });
}

const char* verdictName(check::Severity worst) {
  return worst == check::Severity::note ? "fine" : check::name(worst);
}

void writeJson(const std::string& path, const RecordingCheck& recording,
               const std::vector<check::Finding>& findings) {
  nlohmann::ordered_json json;
  json["verdict"] = verdictName(check::worst(findings));
  json["streams"] = nlohmann::json::array();
  for (const check::StreamSummary& s : recording.streams()) {
    json["streams"].push_back({{"label", s.label},
                               {"count", s.count},
                               {"rate_hz", s.rate_hz},
                               {"first_ns", s.first},
                               {"last_ns", s.last},
                               {"jitter_s", s.jitter_s},
                               {"longest_gap_s", s.longest_gap_s},
                               {"out_of_order", s.out_of_order},
                               {"repeated", s.repeated}});
  }
  json["findings"] = nlohmann::json::array();
  for (const check::Finding& f : findings) {
    json["findings"].push_back({{"severity", check::name(f.severity)},
                                {"kind", f.kind},
                                {"stream", f.stream},
                                {"what", f.what},
                                {"evidence", f.evidence},
                                {"remedy", f.remedy}});
  }
  std::ofstream out(path, std::ios::binary);
  out << json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
  out.close();
  if (!out) throw std::runtime_error("cannot write JSON to " + path);
}

}  // namespace vir::app
