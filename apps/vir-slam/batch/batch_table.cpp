#include "batch/batch_table.h"

#include <algorithm>
#include <sstream>

#include "batch/batch_columns.h"
#include "output/console.h"

namespace vir::app {
namespace {

using Maybe = std::optional<double>;

}  // namespace

std::string batchMarkdown(const BatchPlan& plan, const std::vector<BatchRow>& rows) {
  std::ostringstream out;
  out << "| # | recording | setting |";
  for (const BatchColumn& c : batchColumns()) out << ' ' << c.head << " |";
  out << "\n|---|---|---|";
  for (std::size_t i = 0; i < batchColumns().size(); ++i) out << "---|";
  out << '\n';
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t k = 0; k < rows[i].cells.size(); ++k) {
      const BatchCell& cell = rows[i].cells[k];
      out << "| " << (k == 0 ? std::to_string(i + 1) : "") << " | " << (k == 0 ? rows[i].name : "")
          << " | " << titleOf(plan.settings[k]) << " |";
      for (const BatchColumn& c : batchColumns()) {
        const bool bold = cell.best && c.ate;
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

std::string batchText(const BatchPlan& plan, const std::vector<BatchRow>& rows) {
  std::vector<std::vector<std::string>> lines(1, {"recording", "setting"});
  for (const BatchColumn& c : batchColumns()) {
    if (c.terminal) lines[0].emplace_back(c.head);
  }
  for (const BatchRow& row : rows) {
    for (std::size_t k = 0; k < row.cells.size(); ++k) {
      std::vector<std::string> line{k == 0 ? row.name : "", titleOf(plan.settings[k])};
      for (const BatchColumn& c : batchColumns()) {
        if (c.terminal)
          line.push_back(c.text(row.cells[k]) + (row.cells[k].best && c.ate ? "*" : " "));
      }
      lines.push_back(std::move(line));
    }
  }
  std::vector<std::size_t> width(lines[0].size(), 0);
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) width[i] = std::max(width[i], line[i].size());
  }
  std::string out;
  for (const auto& line : lines) {
    std::string text;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const std::string gap(width[i] - line[i].size(), ' ');
      text += i < 2 ? line[i] + gap + "  " : gap + line[i] + " ";
    }
    out += text.substr(0, text.find_last_not_of(' ') + 1) + "\n";
  }
  return out + "* the best of its recording\n";
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

}  // namespace vir::app
