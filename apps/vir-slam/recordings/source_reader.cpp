#include "recordings/source_reader.h"

#include <filesystem>

#include "commands/commands.h"
#include "recordings/companion.h"
#include "recordings/import_job.h"
#include "vir/rawlog/rawlog_reader.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

using Visit = std::function<void(mrpt::obs::CObservation&, double)>;

SourceReport readRawlog(const std::string& path, const Visit& visit) {
  rawlog::RawlogReader reader(path);
  while (const auto o = reader.next()) visit(*o, reader.progress());
  SourceReport out;
  for (const std::string& problem : {reader.damage(), reader.refusals()}) {
    if (!problem.empty()) out.notes.push_back(problem);
  }
  out.damaged = !reader.damage().empty();
  out.anchors.truth = anchorsTruthOf(path).anchors;
  out.anchors.survey = surveyOf(path);
  out.anchor_texts = anchorTextsOf(path);
  return out;
}

}  // namespace

SourceReport reportOf(const roles::RecordedSource& source) {
  SourceReport out;
  out.notes = source.warnings();
  for (const roles::TrueAnchor& a : source.trueAnchors()) out.anchors.truth[a.id] = a.p_W;
  out.anchors.survey = source.surveyedAnchors();
  out.anchor_texts = anchorTextsIn(source.companionIni());
  const auto names = [](const std::string& counter, const std::string& part) {
    return counter.find(part) != std::string::npos;
  };
  for (const auto& [name, n] : source.counters()) {
    if (n == 0) continue;
    if (name == roles::kDamageCounter) out.damaged = true;
    if (name == "table_by_position") out.by_position = n;
    if (name == "table_not_read") out.not_read = n;
    if (name == roles::kUselessCounter) out.useless = n;
    if (name == "imu_repeated") out.imu_repeated = n;
    if (names(name, "_too_late")) out.too_late += n;
    if (names(name, "_malformed") || names(name, "undecodable") || name == "image_missing") {
      out.unreadable.push_back({name, n});
    }
  }
  return out;
}

bool isRawlog(const std::string& source) {
  const fs::path path(source);
  return path.extension() == ".rawlog" ||
         (path.extension() == ".gz" && path.stem().extension() == ".rawlog");
}

SourceReport readSource(const SourceToRead& what, const Visit& visit) {
  if (isRawlog(what.source) && fs::exists(what.source)) {
    if (!what.topics.empty()) {
      throw UsageError("--topic is for a recording that is imported; " + what.source + " is none");
    }
    return readRawlog(what.source, visit);
  }
  ImportJob job;
  job.source = what.source;
  job.calibration = what.calibration;
  // Without a folder for images they stay in memory.
  job.set = what.set;
  job.topics = what.topics;
  const auto [sensor, source, driver] = openSource(job);
  sensor->initialize();
  bool more = true;
  while (more) {
    more = !source->finished();
    if (more) sensor->doProcess();
    for (const auto& o : sensor->takeObservations()) visit(*o, source->progress());
  }
  SourceReport out = reportOf(*source);
  out.driver = driver;
  return out;
}

}  // namespace vir::app
