#pragma once
/// What the runs of a benchmark amount to, for people and for programs.
#include <optional>
#include <string>
#include <vector>

#include "batch/batch_plan.h"

namespace vir::app {

/// One run, from its summary.json; empty where the run has no such number.
struct BatchResult {
  std::string recording, row, setting;
  int seed = 0;
  std::string problem;  ///< why there is nothing; "not run" if nobody tried
  std::string run;      ///< its folder; empty if there is none
  std::string verdict;
  std::optional<double> ate_m, smoothed_m, rpe_1s_m, rpe_10m_m, rotation_deg;
  std::optional<double> coverage;  ///< poses per image
  std::optional<double> init_s, cpu_ms, nees;
  std::optional<double> anchor_m;  ///< mean error of the anchors whose truth is known
  long resets = 0;
};

/// The runs of one setting on one row.
struct BatchCell {
  std::string setting;
  int runs = 0, failed = 0, missing = 0;  ///< `runs` planned, of which ...
  std::optional<double> ate_median_m, ate_worst_m, smoothed_median_m, rpe_1s_m, rpe_10m_m;
  std::optional<double> coverage, init_s, cpu_ms, nees, anchor_m;
  bool best = false;  ///< smallest median ATE of the row among settings without failures
};

struct BatchRow {
  std::string name, note;
  std::vector<BatchCell> cells;  ///< in the order of the plan's settings
};

/// Reads what there is of the plan's runs in the results folders; the first folder that has a run
/// wins.
std::vector<BatchResult> readBatchResults(const BatchPlan& plan,
                                          const std::vector<std::string>& folders);

/// Medians (NEES: mean) over the seeds of every row.
std::vector<BatchRow> batchRows(const BatchPlan& plan, const std::vector<BatchResult>& results);

std::string batchMarkdown(const BatchPlan& plan, const std::vector<BatchRow>& rows);
/// The columns that most look for, in lines that fit a terminal.
std::string batchText(const BatchPlan& plan, const std::vector<BatchRow>& rows);
/// A line per run.
std::string batchCsv(const std::vector<BatchResult>& results);
/// The table as a page: a dot for the error of every run, with a link to its report. `folder` is
/// where the page will be; `command` makes it.
std::string batchHtml(const BatchPlan& plan, const std::vector<BatchRow>& rows,
                      const std::vector<BatchResult>& results, const std::string& folder,
                      const std::string& command);

}  // namespace vir::app
