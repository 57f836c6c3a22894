#include "recordings/full_check.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "recordings/companion.h"
#include "vir/core/settings.h"
#include "vir/imu/preintegration.h"

namespace vir::app {

void assumeAsIn(const Settings& settings, RecordingCheck* check) {
  imu::ImuNoise noise;
  SettingsReader reader(settings);
  imu::describe(reader, noise);
  check->setNoise(noise);
  double time_offset_s = 0;
  reader.section("Camera", "");
  reader.value("time_offset_s", time_offset_s, {-10.0, 10.0}, "image stamp + offset = IMU clock");
  check->setTimeOffset(time_offset_s);
  std::vector<double> others_s;
  reader.value("other_time_offsets_s", others_s, 0, "the same of CAM1, CAM2, ...");
  check->setOtherTimeOffsets(others_s);
}

SourceReport checkAll(const SourceToRead& what, GivenCalibration* calibration,
                      RecordingCheck* check, const std::function<void(double)>& progress) {
  const bool rawlog = isRawlog(what.source);
  SourceReport report = readSource(what, [&](mrpt::obs::CObservation& o, double part) {
    if (rawlog) calibration->apply(&o);
    check->add(o);
    if (progress) progress(part);
  });
  check->setAnchors(report.anchors);
  check->setAnchorTexts(report.anchor_texts);
  return report;
}

std::vector<std::string> unusedCameras(const RecordingCheck& check, const Settings& used) {
  const Setting* others = used.find("Estimator", "other_cameras");
  const Setting* first = used.find("Estimator", "camera_label");
  if (first == nullptr || others == nullptr || others->value == "auto") return {};
  std::istringstream labels(others->value);
  std::vector<std::string> used_ones, out;
  for (std::string label; labels >> label;) used_ones.push_back(label);
  bool there = false;
  for (const check::StreamSummary& s : check.streams()) {
    if (s.kind != check::StreamKind::images) continue;
    if (s.label == first->value) there = true;
    const bool asked = std::find(used_ones.begin(), used_ones.end(), s.label) != used_ones.end();
    if (s.label != first->value && !asked) out.push_back(s.label);
  }
  return there ? out : std::vector<std::string>();
}

std::vector<std::string> causesIn(const std::string& rawlog, const Settings& used,
                                  GivenCalibration calibration, const std::string& driver) {
  RecordingCheck check(RecordingCheck::Depth::full);
  check.setDriver(driver);
  try {
    assumeAsIn(used, &check);
    checkAll({rawlog, {}, {}}, &calibration, &check, {});
  } catch (const std::exception&) {
    // The run has said what there is to say of a file that ends in the middle; what was read
    // counts.
  }
  std::vector<std::string> out;
  for (const check::Finding& f : doubtfulFindings(check, unusedCameras(check, used))) {
    out.push_back(check::line(f));
  }
  return out;
}

std::vector<std::string> doubtsOf(const RecordingCheck& brief, const std::string& rawlog,
                                  const std::string& driver) {
  const std::vector<check::Finding> findings = brief.findings();
  const bool open = std::any_of(findings.begin(), findings.end(), [](const check::Finding& f) {
    return f.kind == "acc_negated" && f.severity == check::Severity::doubtful;
  });
  if (!open) return briefLines(brief);
  const std::string companion = companionOf(rawlog);
  const Settings settings = companion.empty() ? Settings() : Settings::fromFile(companion);
  const std::vector<std::string> lines = causesIn(rawlog, settings, GivenCalibration(), driver);
  return lines.empty() ? briefLines(brief) : lines;
}

}  // namespace vir::app
