/// A sensor to its end into a rawlog, with the files that go beside it.
#include "recordings/rawlog_recorder.h"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <vector>

#include "commands/commands.h"
#include "output/check_report.h"
#include "output/console.h"
#include "recordings/full_check.h"
#include "recordings/image_folder.h"
#include "recordings/recording_check.h"
#include "recordings/source_reader.h"
#include "vir/core/text_file.h"
#include "vir/rawlog/labels.h"
#include "vir/rawlog/mrpt_time.h"
#include "vir/rawlog/rawlog_writer.h"
#include "vir/rawlog/stereo_images.h"
#include "vir/results/output_lock.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

/// In quotes where a shell would take it apart.
std::string inShell(const std::string& text) {
  const bool plain = text.find_first_not_of(
                         "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._/+-") ==
                     std::string::npos;
  if (plain) return text;
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// What went into the rawlog under one label.
struct LabelStatistics {
  long count = 0;
  TimeNs first = 0, last = 0, longest_gap = 0;

  void add(TimeNs t) {
    if (count > 0) longest_gap = std::max(longest_gap, t - last);
    if (count == 0) first = t;
    last = t;
    ++count;
  }
};
using Statistics = std::map<std::string, LabelStatistics>;

/// Runs the sensor to its end.
Statistics pump(roles::Sensor& sensor, roles::RecordedSource& source, rawlog::RawlogWriter& writer,
                rawlog::PairJoiner* joiner, RecordingCheck* check) {
  Statistics statistics;
  ProgressBar bar;
  const auto write = [&writer](const std::vector<mrpt::obs::CObservation::Ptr>& all) {
    for (const mrpt::obs::CObservation::Ptr& obs : all) writer.write(*obs);
  };
  bool more = true;
  while (more) {
    if (interrupted()) throw std::runtime_error("interrupted; no rawlog was written");
    more = !source.finished();
    if (more) sensor.doProcess();
    for (const mrpt::obs::CObservation::Ptr& obs : sensor.takeObservations()) {
      write(joiner != nullptr ? joiner->add(obs) : std::vector{obs});
      check->add(*obs);
      statistics[obs->sensorLabel].add(rawlog::fromMrptTime(obs->timestamp));
    }
    bar.show(source.progress());
  }
  if (joiner != nullptr) write(joiner->finish());
  return statistics;
}

/// `x` of `x.rawlog`.
std::string stemOf(const std::string& rawlog) {
  for (const std::string suffix : {".rawlog", ".rawlog.gz"}) {
    const std::size_t n = suffix.size();
    if (rawlog.size() > n && rawlog.compare(rawlog.size() - n, n, suffix) == 0) {
      return rawlog.substr(0, rawlog.size() - n);
    }
  }
  throw UsageError("--out " + rawlog + ": must end in .rawlog");
}

constexpr const char* kIniMark = "// Written by vir-slam ";
constexpr const char* kAnchorsMark = "#id,x,y,z";
constexpr const char* kSurveyMark = "#id,x,y,z as the recording tells";

/// Writes a file that goes with the recording beside its rawlog, or removes what an older import
/// left there if there is nothing to say. A file that does not begin with `mark` is not ours and is
/// left alone. Returns a line for the report.
std::string writeCompanion(const std::string& path, const std::string& mark,
                           const std::string& text) {
  if (fs::exists(path)) {
    std::string first;
    std::ifstream old(path);
    readLine(old, &first);
    if (first.rfind(mark, 0) != 0) {
      return text.empty() ? ""
                          : path +
                                " is not from an import or a simulation and was left as it is; "
                                "what goes with "
                                "this recording was not written\n";
    }
    fs::remove(path);
  }
  if (text.empty()) return "";
  const std::string part = path + ".part";
  std::ofstream file(part, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw std::runtime_error("cannot write " + part);
  fs::rename(part, path);
  return "wrote " + path + "\n";
}

std::string iniText(const roles::RecordedSource& source, const std::string& rawlog,
                    const std::string& command) {
  const std::string text = source.companionIni();
  if (text.empty()) return "";
  return kIniMark + command + " beside " + fs::path(rawlog).filename().string() +
         "; `vir-slam run` takes from here what its own ini does not set.\n" + text;
}

std::string anchorLine(std::uint64_t id, const Vec3& p) {
  char line[128];
  std::snprintf(line, sizeof line, "%" PRIu64 ",%.9g,%.9g,%.9g\n", id, p.x(), p.y(), p.z());
  return line;
}

std::string anchorsText(const roles::RecordedSource& source) {
  std::string text;
  for (const roles::TrueAnchor& a : source.trueAnchors()) text += anchorLine(a.id, a.p_W);
  return text.empty() ? ""
                      : std::string(kAnchorsMark) + " in the ground truth's frame [m]\n" + text;
}

/// Writes the anchors' places that the recording tells, and says how a run takes them.
std::string writeSurvey(const roles::RecordedSource& source, const std::string& stem,
                        const std::string& rawlog) {
  std::string text;
  const std::vector<SurveyedAnchor> anchors = source.surveyedAnchors();
  for (const SurveyedAnchor& a : anchors) text += anchorLine(a.id, a.p_S);
  if (!text.empty()) text.insert(0, std::string(kSurveyMark) + " [m]\n");
  const std::string path = stem + "_anchors.csv";
  std::string said = writeCompanion(path, kSurveyMark, text);
  if (said.rfind("wrote ", 0) == 0) {
    said += "  where the recording says that " + std::to_string(anchors.size()) +
            (anchors.size() == 1 ? " anchor is" : " anchors are") +
            "; if that was measured: vir-slam run " + rawlog + " --anchors " + path + "\n";
  }
  return said;
}

void report(const roles::RecordedSource& source, const Statistics& statistics,
            const std::string& out, const std::string& companions) {
  for (const std::string& w : source.warnings()) std::printf("note: %s\n", printable(w).c_str());
  std::printf("%-8s %10s %10s %10s %14s\n", "label", "count", "rate [Hz]", "span [s]",
              "longest gap [s]");
  for (const auto& [label, s] : statistics) {
    const double span = toSeconds(s.last - s.first);
    std::printf("%-8s %10ld %10.2f %10.2f %14.3f\n", label.c_str(), s.count,
                span > 0 ? static_cast<double>(s.count - 1) / span : 0.0, span,
                toSeconds(s.longest_gap));
  }
  std::printf("\nread, and what was skipped or changed:\n");
  for (const auto& [name, n] : source.counters()) std::printf("  %-34s %10ld\n", name.c_str(), n);
  std::printf("\nwrote %s\n", out.c_str());
  std::printf("%s", companions.c_str());
  // MRPT 2.5.8 finds the image folder for a bare file name only.
  const fs::path path(out);
  const std::string folder = path.has_parent_path() ? path.parent_path().string() : ".";
  std::printf("look at it: (cd %s && RawLogViewer %s)\n", inShell(folder).c_str(),
              inShell(path.filename().string()).c_str());
}

/// False, and said, where the rawlog is a part only of what the source has.
bool isComplete(const roles::RecordedSource& source, const std::string& out) {
  bool complete = true;
  for (const auto& [name, n] : source.counters()) {
    if (n == 0) continue;
    if (name == roles::kDamageCounter) {
      std::fprintf(stderr, "vir-slam: the source is damaged or was cut off; %s ends early\n",
                   out.c_str());
      complete = false;
    }
    if (name == roles::kUselessCounter) {
      std::fprintf(stderr,
                   "vir-slam: %s is a part only: of %ld stream%s of the source nothing could be "
                   "used (see above)\n",
                   out.c_str(), n, n == 1 ? "" : "s");
      complete = false;
    }
  }
  return complete;
}

}  // namespace

void requireRawlogName(const std::string& rawlog) { stemOf(rawlog); }

bool recordToRawlog(const RecordingJob& job) {
  const std::string stem = stemOf(job.out);
  const fs::path folder = fs::path(job.out).parent_path();
  std::error_code ignored;  // the writer says it
  if (!folder.empty()) fs::create_directories(folder, ignored);
  const results::OutputLock lock(job.out);
  ImageFolder images(rawlog::RawlogWriter::imageFolderOf(job.out));
  job.sensor->setPathForExternalImages(images.workingFolder());
  job.sensor->initialize();
  rawlog::RawlogWriter writer(job.out, job.compression);
  RecordingCheck check(RecordingCheck::Depth::brief);
  check.setDriver(job.driver);
  std::optional<rawlog::PairJoiner> joiner;
  if (job.stereo) joiner.emplace(rawlog::PairNames().of(rawlog::kCameraLabel));
  const Statistics statistics =
      pump(*job.sensor, *job.source, writer, joiner ? &*joiner : nullptr, &check);
  images.swap();
  writer.finish();
  images.commit();
  const std::string companions =
      writeCompanion(stem + ".ini", kIniMark, iniText(*job.source, job.out, job.command)) +
      writeCompanion(stem + "_anchors_truth.csv", kAnchorsMark, anchorsText(*job.source)) +
      writeSurvey(*job.source, stem, job.out);
  report(*job.source, statistics, job.out, companions);
  if (joiner) {
    std::printf("%ld pairs of images in one observation each, %ld images without a partner\n",
                joiner->pairs(), joiner->single());
  }
  const std::vector<std::string> doubts = doubtsOf(check, job.out, job.driver);
  // What is left out here a look at the rawlog can no longer find. Damage is said below.
  SourceReport read = reportOf(*job.source);
  read.damaged = false;
  read.useless = 0;
  std::vector<check::Finding> of_source;
  addFindings(read, check.streams(), &of_source);
  for (const check::Finding& f : of_source) {
    if (f.severity != check::Severity::note) std::printf("%s\n", check::line(f).c_str());
  }
  for (const std::string& line : doubts) std::printf("%s\n", line.c_str());
  if (!doubts.empty()) std::printf("more: vir-slam check %s\n", job.out.c_str());
  return isComplete(*job.source, job.out);
}

}  // namespace vir::app
