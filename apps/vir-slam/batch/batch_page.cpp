/// table.html: names, links and the error of every run.
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <sstream>

#include "batch/batch_columns.h"
#include "output/console.h"
#include "vir/core/markup.h"
#include "vir/results/plain_page.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

constexpr double kStripWidth = 240, kStripHeight = 18, kEdge = 8;  // [px]

/// A logarithmic axis of whole powers of ten of a metre around all errors.
class ErrorAxis {
 public:
  explicit ErrorAxis(const std::vector<BatchResult>& results) {
    double least = 1e300, most = 0;
    for (const BatchResult& r : results) {
      if (!r.ate_m || !(*r.ate_m > 0) || !std::isfinite(*r.ate_m)) continue;
      least = std::min(least, *r.ate_m);
      most = std::max(most, *r.ate_m);
    }
    if (most <= 0) return;
    low_ = static_cast<int>(std::floor(std::log10(least)));
    high_ = std::max(low_ + 1, static_cast<int>(std::ceil(std::log10(most))));
  }
  int low() const { return low_; }
  int high() const { return high_; }
  double at(double error_m) const {
    const double part = (std::log10(error_m) - low_) / (high_ - low_);
    return kEdge + std::clamp(part, 0.0, 1.0) * (kStripWidth - 2 * kEdge);
  }
  static std::string label(int power) {
    const bool below = power < 0;
    const double value = std::pow(10, power < -2 ? power + 3 : below ? power + 2 : power);
    return shortNumber(value) + (power < -2 ? " mm" : below ? " cm" : " m");
  }

 private:
  static std::string shortNumber(double v) {
    std::ostringstream out;
    out << v;
    return out.str();
  }
  int low_ = -2, high_ = 1;
};

std::string number(double v) { return fixed(v, 1); }

/// One strip of the axis: grid, and `inside`.
std::string strip(const ErrorAxis& axis, const std::string& inside, bool labels) {
  const double height = labels ? 14 : kStripHeight;
  std::string out = "<svg width=\"" + number(kStripWidth) + "\" height=\"" + number(height) +
                    "\" style=\"margin:0;max-width:none;background:none\">";
  for (int power = axis.low(); power <= axis.high(); ++power) {
    const std::string x = number(axis.at(std::pow(10, power)));
    if (labels) {
      const char* anchor = power == axis.low() ? "start" : power == axis.high() ? "end" : "middle";
      const double edge = power == axis.low() ? -kEdge : power == axis.high() ? kEdge : 0;
      out += "<text x=\"" + number(axis.at(std::pow(10, power)) + edge) +
             "\" y=\"11\" font-size=\"11\" fill=\"currentColor\" text-anchor=\"" + anchor + "\">" +
             ErrorAxis::label(power) + "</text>";
    } else {
      out += "<line x1=\"" + x + "\" x2=\"" + x + "\" y1=\"0\" y2=\"" + number(height) +
             "\" stroke=\"var(--line)\"/>";
    }
  }
  return out + inside + "</svg>";
}

/// Where the report of a run is, seen from the page; empty if there is none.
std::string reportOf(const BatchResult& r, const std::string& folder) {
  if (r.run.empty()) return "";
  const fs::path report = fs::path(r.run) / "report.html";
  std::error_code error;
  if (!fs::exists(report, error)) return "";
  return fs::relative(report, folder, error).generic_string();
}

std::string linked(const std::string& report, const std::string& what) {
  return report.empty() ? what : "<a href=\"" + escapedMarkup(report) + "\">" + what + "</a>";
}

std::string dots(const ErrorAxis& axis, const std::string& folder,
                 const std::vector<const BatchResult*>& runs) {
  std::string out;
  for (const BatchResult* r : runs) {
    if (!r->ate_m || !(*r->ate_m > 0)) continue;
    const bool trusted = r->verdict.empty() || r->verdict == "good";
    const std::string title = r->recording + ": " + fixed(*r->ate_m, 4) + " m" +
                              (r->verdict.empty() ? "" : ", " + r->verdict);
    const std::string dot = "<circle cx=\"" + number(axis.at(*r->ate_m)) + "\" cy=\"" +
                            number(kStripHeight / 2) + "\" r=\"5\" fill=\"var(--" +
                            (trusted ? "c0" : "bad") + ")\" fill-opacity=\"0.75\"><title>" +
                            escapedMarkup(title) + "</title></circle>";
    out += linked(reportOf(*r, folder), dot);
  }
  return out;
}

std::string table(const BatchPlan& plan, const std::vector<BatchRow>& rows,
                  const std::vector<BatchResult>& results, const std::string& folder) {
  const ErrorAxis axis(results);
  std::ostringstream out;
  out << "<div class=\"scroll\"><table>\n<tr><th>recording</th><th>setting</th><th>ATE of every run"
      << strip(axis, "", true) << "</th>";
  for (const BatchColumn& c : batchColumns()) out << "<th class=\"n\">" << c.head << "</th>";
  out << "</tr>\n";
  for (const BatchRow& row : rows) {
    for (std::size_t k = 0; k < row.cells.size(); ++k) {
      const BatchCell& cell = row.cells[k];
      std::vector<const BatchResult*> runs;
      for (const BatchResult& r : results) {
        if (r.row == row.name && r.setting == cell.setting) runs.push_back(&r);
      }
      out << "<tr><td style=\"white-space:nowrap\">" << (k == 0 ? escapedMarkup(row.name) : "")
          << "</td><td style=\"white-space:nowrap\">" << escapedMarkup(titleOf(plan.settings[k]))
          << "</td><td>" << strip(axis, dots(axis, folder, runs), false) << "</td>";
      for (const BatchColumn& c : batchColumns()) {
        const bool best = cell.best && c.ate;
        out << "<td class=\"n\">" << (best ? "<b>" : "") << c.text(cell) << (best ? "</b>" : "")
            << "</td>";
      }
      out << "</tr>\n";
    }
  }
  out << "</table></div>\n";
  return out.str();
}

std::string runs(const std::vector<BatchResult>& results, const std::string& folder) {
  std::string out =
      "<h2>Every run</h2>\n<div class=\"scroll\"><table>\n<tr><th>recording</th><th>setting</th>"
      "<th>verdict</th><th class=\"n\">ATE [m]</th><th></th></tr>\n";
  for (const BatchResult& r : results) {
    const std::string report = reportOf(r, folder);
    const std::string state = r.problem.empty() ? r.verdict : r.problem;
    const bool bad = !r.problem.empty() || (r.verdict != "good" && !r.verdict.empty());
    out += "<tr><td>" + escapedMarkup(r.recording) + "</td><td>" + escapedMarkup(r.setting) +
           "</td><td" + (bad ? " class=\"bad\">" : ">") + escapedMarkup(state) +
           "</td><td class=\"n\">" + (r.ate_m ? fixed(*r.ate_m, 4) : "-") + "</td><td>" +
           (report.empty() ? "" : linked(report, "report")) + "</td></tr>\n";
  }
  return out + "</table></div>\n";
}

/// When the last of the runs ended: not now, for the page may be made again.
std::string lastRun(const std::vector<BatchResult>& results) {
  std::time_t last = 0;
  for (const BatchResult& r : results) {
    struct stat entry {};
    const std::string summary = r.run + "/summary.json";
    if (!r.run.empty() && stat(summary.c_str(), &entry) == 0) last = std::max(last, entry.st_mtime);
  }
  if (last == 0) return "";
  return "<p class=\"small\">The last of the runs ended at " +
         results::dateText(fromSeconds(static_cast<double>(last))) + ".</p>\n";
}

}  // namespace

std::string batchHtml(const BatchPlan& plan, const std::vector<BatchRow>& rows,
                      const std::vector<BatchResult>& results, const std::string& folder,
                      const std::string& command) {
  std::string content = "<h1>Benchmark " + escapedMarkup(plan.file) + "</h1>\n";
  content +=
      "<p class=\"small\">Errors of the causal trajectory, aligned in position and yaw. Medians "
      "over the seeds; a dot per run, on a logarithmic axis, red where its verdict is not good: it "
      "leads to the run's own page.</p>\n";
  content += lastRun(results);
  content += table(plan, rows, results, folder);
  for (const BatchRow& row : rows) {
    if (row.note.empty()) continue;
    content += "<p>" + escapedMarkup(row.name) + ": " + escapedMarkup(row.note) + "</p>\n";
  }
  return results::plainPage("vir-slam: benchmark " + plan.file, content + runs(results, folder),
                            command);
}

}  // namespace vir::app
