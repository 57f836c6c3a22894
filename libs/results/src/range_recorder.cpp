#include "range_recorder.h"

#include <cmath>

#include "csv_text.h"
#include "vir/evaluation/trajectory.h"

namespace vir::results {
namespace {

using namespace csv;

constexpr const char* kRangesHeader =
    "t_s,id,measured_m,predicted_m,residual_m,sigma_m,weight,decision,reference";
constexpr const char* kAnchorsHeader =
    "id,x,y,z,cov_xx,cov_xy,cov_xz,cov_yx,cov_yy,cov_yz,cov_zx,cov_zy,cov_zz,state,bias_m,"
    "bias_sigma_m,ranges_used,ranges_rejected,mirror_x_m,mirror_y_m,mirror_z_m,advice";

std::string rangeLine(const RangeRecord& r) {
  std::string line = evaluation::formatSeconds(r.t) + "," + std::to_string(r.anchor) + "," +
                     csvNumber(r.measured_m);
  const bool predicted = r.sigma_m > 0 || r.predicted_m != 0;
  for (const double v : {r.predicted_m, r.residual_m, r.sigma_m}) {
    line += "," + (predicted ? csvNumber(v) : std::string());
  }
  line += "," + csvNumber(r.weight) + "," + name(r.decision) + ",";
  return r.reference ? line + std::to_string(*r.reference) : line;
}

std::string vectorOrNothing(const Vec3& v, bool known) {
  std::string text;
  for (int i = 0; i < 3; ++i) text += "," + (known ? csvNumber(v[i]) : std::string());
  return text;
}

std::string anchorLine(const Anchor& a) {
  const bool known = a.has_position && a.p_W.allFinite();
  std::string line = std::to_string(a.id) + vectorOrNothing(a.p_W, known);
  for (int r = 0; r < 3; ++r) line += vectorOrNothing(a.covariance.row(r), known);
  line += std::string(",") + name(a.state) + "," + csvNumber(a.bias_m) + "," +
          csvNumber(a.bias_sigma_m) + "," + std::to_string(a.ranges_used) + "," +
          std::to_string(a.ranges_rejected);
  line += vectorOrNothing(a.mirror_p_W, a.state == AnchorState::mirror_open);
  return line + "," + csvWord(a.advice);
}

}  // namespace

RangeRecorder::RangeRecorder(const ResultsFolder& folder)
    : folder_(folder), file_(folder.file("ranges.csv")) {
  file_.line(kRangesHeader);
}

void RangeRecorder::add(const RangeRecord& record) {
  file_.line(rangeLine(record));
  ++decisions_[record.decision];
  if (record.decision == RangeDecision::accepted) {
    ++accepted_;
  } else if (record.decision == RangeDecision::collected) {
    ++collected_;
  } else if (record.decision == RangeDecision::before_the_start) {
    ++before_start_;
  } else {
    ++rejected_;
  }
  sample_.add(record);
}

void RangeRecorder::finish(const std::vector<Anchor>& anchors) {
  file_.close();
  OutputFile file(folder_.file("anchors.csv"));
  file.line(kAnchorsHeader);
  for (const Anchor& a : anchors) file.line(anchorLine(a));
  file.close();
}

std::vector<std::pair<std::string, long>> RangeRecorder::counters() const {
  std::vector<std::pair<std::string, long>> out;
  for (const auto& [decision, count] : decisions_) {
    out.emplace_back(std::string("ranges_") + name(decision), count);
  }
  return out;
}

}  // namespace vir::results
