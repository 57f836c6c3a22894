#include "range_recorder.h"

#include <cctype>
#include <cmath>

#include "csv_text.h"
#include "vir/evaluation/trajectory.h"

namespace vir::results {
namespace {

using namespace csv;

constexpr const char* kRangesHeader =
    "t_s,id,measured_m,predicted_m,residual_m,sigma_m,weight,decision";
constexpr const char* kAnchorsHeader =
    "id,x,y,z,cov_xx,cov_xy,cov_xz,cov_yx,cov_yy,cov_yz,cov_zx,cov_zy,cov_zz,state,bias_m,"
    "bias_sigma_m,ranges_used,ranges_rejected,mirror_x_m,mirror_y_m,mirror_z_m,advice";
/// A reason with numbers in it would make a counter per range.
constexpr std::size_t kMaxReasons = 40;

std::string rangeLine(const roles::RangeRecord& r) {
  std::string line =
      evaluation::formatSeconds(r.t) + "," + std::to_string(r.id) + "," + csvNumber(r.measured_m);
  const bool predicted = r.sigma_m > 0 || r.predicted_m != 0;
  for (const double v : {r.predicted_m, r.residual_m, r.sigma_m}) {
    line += "," + (predicted ? csvNumber(v) : std::string());
  }
  return line + "," + csvNumber(r.weight) + "," + csvWord(r.decision);
}

std::string vectorOrNothing(const Vec3& v, bool known) {
  std::string text;
  for (int i = 0; i < 3; ++i) text += "," + (known ? csvNumber(v[i]) : std::string());
  return text;
}

std::string anchorLine(const roles::AnchorEstimate& a) {
  const bool known = a.has_position && a.p_W.allFinite();
  std::string line = std::to_string(a.id) + vectorOrNothing(a.p_W, known);
  for (int r = 0; r < 3; ++r) line += vectorOrNothing(a.covariance.row(r), known);
  line += "," + csvWord(a.state) + "," + csvNumber(a.bias_m) + "," + csvNumber(a.bias_sigma_m) +
          "," + std::to_string(a.ranges_used) + "," + std::to_string(a.ranges_rejected);
  line += vectorOrNothing(a.mirror_p_W, a.state == "mirror_open");
  return line + "," + csvWord(a.advice);
}

std::string counterName(const std::string& decision) {
  std::string name = "ranges_";
  for (const char c : decision) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0;
    if (plain || name.back() != '_') name += plain ? c : '_';
  }
  while (name.back() == '_') name.pop_back();
  return name == "ranges" ? "ranges_without_decision" : name;
}

}  // namespace

RangeRecorder::RangeRecorder(const ResultsFolder& folder)
    : folder_(folder), file_(folder.file("ranges.csv")) {
  file_.line(kRangesHeader);
}

void RangeRecorder::add(const roles::RangeRecord& record) {
  file_.line(rangeLine(record));
  std::string name = counterName(record.decision);
  if (decisions_.size() >= kMaxReasons && decisions_.count(name) == 0) name = "ranges_other";
  ++decisions_[name];
  if (record.decision == "accepted") {
    ++accepted_;
  } else if (record.decision == "collected") {
    ++collected_;
  } else {
    ++rejected_;
  }
  keepForPictures(record);
}

void RangeRecorder::keepForPictures(const roles::RangeRecord& record) {
  if (seen_++ % stride_ == 0) sample_.push_back(record);
  if (sample_.size() < 2 * kShown) return;
  for (std::size_t i = 0; 2 * i < sample_.size(); ++i) sample_[i] = sample_[2 * i];
  sample_.resize(sample_.size() / 2);
  stride_ *= 2;
}

void RangeRecorder::finish(const std::vector<roles::AnchorEstimate>& anchors) {
  file_.close();
  OutputFile file(folder_.file("anchors.csv"));
  file.line(kAnchorsHeader);
  for (const roles::AnchorEstimate& a : anchors) file.line(anchorLine(a));
  file.close();
}

std::vector<std::pair<std::string, long>> RangeRecorder::counters() const {
  return {decisions_.begin(), decisions_.end()};
}

}  // namespace vir::results
