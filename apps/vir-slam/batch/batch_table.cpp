#include "batch/batch_table.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <sstream>

#include "output/console.h"
#include "vir/core/markup.h"
#include "vir/evaluation/figure.h"
#include "vir/evaluation/figure_parts.h"

namespace vir::app {
namespace {

using Maybe = std::optional<double>;

std::string cellText(const Maybe& v, int decimals) { return v ? fixed(*v, decimals) : "-"; }

std::string titleOf(const BatchSetting& s) { return s.title.empty() ? s.name : s.title; }

/// One column of the table behind the names of row and setting.
struct Column {
  const char* head;
  std::function<std::string(const BatchCell&)> text;
};

const std::vector<Column>& columns() {
  static const std::vector<Column> all{
      {"runs",
       [](const BatchCell& c) {
         std::string text = std::to_string(c.runs);
         if (c.failed > 0) text += " (" + std::to_string(c.failed) + " failed)";
         if (c.missing > 0) text += " (" + std::to_string(c.missing) + " missing)";
         return text;
       }},
      {"ATE median [m]", [](const BatchCell& c) { return cellText(c.ate_median_m, 3); }},
      {"ATE worst [m]", [](const BatchCell& c) { return cellText(c.ate_worst_m, 3); }},
      {"smoothed [m]", [](const BatchCell& c) { return cellText(c.smoothed_median_m, 3); }},
      {"RPE 1 s [m]", [](const BatchCell& c) { return cellText(c.rpe_1s_m, 4); }},
      {"RPE 10 m [m]", [](const BatchCell& c) { return cellText(c.rpe_10m_m, 3); }},
      {"anchor [m]", [](const BatchCell& c) { return cellText(c.anchor_m, 2); }},
      {"NEES", [](const BatchCell& c) { return cellText(c.nees, 2); }},
      {"coverage [%]",
       [](const BatchCell& c) { return c.coverage ? fixed(100 * *c.coverage, 1) : "-"; }},
      {"first pose [s]", [](const BatchCell& c) { return cellText(c.init_s, 2); }},
      {"CPU [ms/image]", [](const BatchCell& c) { return cellText(c.cpu_ms, 1); }},
  };
  return all;
}

bool isAte(const Column& column) { return std::string(column.head) == "ATE median [m]"; }

/// Dots beside each other per setting, rows from left to right, on a logarithmic axis.
struct DotPlot {
  std::string title, y_label;
  Maybe BatchResult::*field;
  bool logarithmic;
};

evaluation::Panel dotPanel(const DotPlot& plot, const BatchPlan& plan,
                           const std::vector<BatchRow>& rows,
                           const std::vector<BatchResult>& results, const Vec2& corner,
                           const Vec2& size) {
  evaluation::Panel panel;
  panel.corner = corner;
  panel.size = size;
  panel.title = plot.title;
  panel.y_label = plot.y_label;
  panel.x_label = "row of the table";
  panel.from_zero = !plot.logarithmic;
  std::map<std::string, std::size_t> row_index, setting_index;
  for (std::size_t i = 0; i < rows.size(); ++i) row_index[rows[i].name] = i;
  for (std::size_t i = 0; i < plan.settings.size(); ++i) setting_index[plan.settings[i].name] = i;
  const double step = 0.7 / static_cast<double>(plan.settings.size());
  for (const BatchResult& r : results) {
    const Maybe& value = r.*plot.field;
    if (!value || (plot.logarithmic && *value <= 0)) continue;
    const std::size_t s = setting_index.at(r.setting);
    const double x =
        1 + static_cast<double>(row_index.at(r.row)) - 0.35 + step * (static_cast<double>(s) + 0.5);
    const double y = plot.logarithmic ? std::log10(*value) : *value;
    panel.dots.emplace_back(Vec2(x, y), evaluation::figureColor(s));
    panel.extent.emplace_back(0.5, y);
    panel.extent.emplace_back(static_cast<double>(rows.size()) + 0.5, y);
  }
  return panel;
}

evaluation::Figure overview(const BatchPlan& plan, const std::vector<BatchRow>& rows,
                            const std::vector<BatchResult>& results) {
  evaluation::Figure figure;
  const double width = std::clamp(60.0 * static_cast<double>(rows.size()), 500.0, 1400.0);
  figure.width = width + 120;
  figure.height = 860;
  figure.title = "Every run";
  figure.subtitle = "one dot per seed; rows are numbered as in the table";
  figure.legend = Vec2(70, 60);
  for (std::size_t i = 0; i < plan.settings.size(); ++i) {
    figure.entries.push_back({titleOf(plan.settings[i]), evaluation::figureColor(i)});
  }
  const double top = 90 + 20 * static_cast<double>(plan.settings.size());
  const double height = (figure.height - top - 3 * 60) / 2;
  const DotPlot ate{"Position error", "log10 of ATE in m", &BatchResult::ate_m, true};
  const DotPlot cpu{"CPU time", "ms per image", &BatchResult::cpu_ms, false};
  figure.panels.push_back(dotPanel(ate, plan, rows, results, Vec2(70, top), Vec2(width, height)));
  figure.panels.push_back(
      dotPanel(cpu, plan, rows, results, Vec2(70, top + height + 80), Vec2(width, height)));
  return figure;
}

}  // namespace

std::string batchMarkdown(const BatchPlan& plan, const std::vector<BatchRow>& rows) {
  std::ostringstream out;
  out << "| # | recording | setting |";
  for (const Column& c : columns()) out << ' ' << c.head << " |";
  out << "\n|---|---|---|";
  for (std::size_t i = 0; i < columns().size(); ++i) out << "---|";
  out << '\n';
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t k = 0; k < rows[i].cells.size(); ++k) {
      const BatchCell& cell = rows[i].cells[k];
      out << "| " << (k == 0 ? std::to_string(i + 1) : "") << " | " << (k == 0 ? rows[i].name : "")
          << " | " << titleOf(plan.settings[k]) << " |";
      for (const Column& c : columns()) {
        const bool bold = cell.best && isAte(c);
        out << (bold ? " **" : " ") << c.text(cell) << (bold ? "** |" : " |");
      }
      out << '\n';
    }
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!rows[i].note.empty()) out << '\n' << i + 1 << ": " << rows[i].note << '\n';
  }
  return out.str();
}

std::string batchCsv(const std::vector<BatchResult>& results) {
  std::ostringstream out;
  out << "recording,row,seed,setting,ate_m,ate_deg,smoothed_m,rpe_1s_m,rpe_10m_m,anchor_m,nees,"
         "coverage,init_s,cpu_ms,resets,problem\n";
  for (const BatchResult& r : results) {
    out << r.recording << ',' << r.row << ',' << r.seed << ',' << r.setting;
    for (const Maybe& v : {r.ate_m, r.rotation_deg, r.smoothed_m, r.rpe_1s_m, r.rpe_10m_m,
                           r.anchor_m, r.nees, r.coverage, r.init_s, r.cpu_ms}) {
      out << ',' << (v ? fixed(*v, 6) : "");
    }
    std::string problem = r.problem;
    std::replace(problem.begin(), problem.end(), ',', ';');
    out << ',' << r.resets << ',' << problem << '\n';
  }
  return out.str();
}

std::string batchHtml(const BatchPlan& plan, const std::vector<BatchRow>& rows,
                      const std::vector<BatchResult>& results) {
  std::ostringstream out;
  out << "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
         "<title>vir-slam benchmark</title>\n<style>\n"
         "body { font: 14px sans-serif; margin: 2em; color: #222; }\n"
         "table { border-collapse: collapse; }\n"
         "th, td { padding: 3px 9px; text-align: right; }\n"
         "th { border-bottom: 2px solid #444; }\n"
         "tr.first td { border-top: 1px solid #bbb; }\n"
         "td.text { text-align: left; }\n.best { font-weight: bold; }\n"
         "</style></head><body>\n<h1>Benchmark "
      << escapedMarkup(plan.file) << "</h1>\n<table>\n<tr><th>#</th><th>recording</th>"
      << "<th>setting</th>";
  for (const Column& c : columns()) out << "<th>" << c.head << "</th>";
  out << "</tr>\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t k = 0; k < rows[i].cells.size(); ++k) {
      const BatchCell& cell = rows[i].cells[k];
      out << (k == 0 ? "<tr class=\"first\"><td>" : "<tr><td>")
          << (k == 0 ? std::to_string(i + 1) : "") << "</td><td class=\"text\">"
          << (k == 0 ? escapedMarkup(rows[i].name) : "") << "</td><td class=\"text\">"
          << escapedMarkup(titleOf(plan.settings[k])) << "</td>";
      for (const Column& c : columns()) {
        out << (cell.best && isAte(c) ? "<td class=\"best\">" : "<td>") << c.text(cell) << "</td>";
      }
      out << "</tr>\n";
    }
  }
  out << "</table>\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].note.empty()) continue;
    out << "<p>" << i + 1 << ": " << escapedMarkup(rows[i].note) << "</p>\n";
  }
  out << evaluation::toSvgElement(overview(plan, rows, results)) << "\n";
  bool any = false;
  for (const BatchResult& r : results) {
    if (r.problem.empty()) continue;
    out << (any ? "" : "<h2>Without a result</h2>\n<ul>\n") << "<li>" << escapedMarkup(r.recording)
        << " / " << escapedMarkup(r.setting) << ": " << escapedMarkup(r.problem) << "</li>\n";
    any = true;
  }
  if (any) out << "</ul>\n";
  out << "</body></html>\n";
  return out.str();
}

}  // namespace vir::app
