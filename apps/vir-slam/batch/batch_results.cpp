/// From the folders of the runs to the numbers of the table.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "batch/batch_run.h"
#include "batch/batch_table.h"
#include "vir/core/order_statistics.h"

namespace vir::app {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;
using Maybe = std::optional<double>;

json readJson(const std::string& path) {
  std::ifstream in(path);
  return in ? json::parse(in, nullptr, false) : json();
}

Maybe number(const json& object, const char* key) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_number()) return std::nullopt;
  return it->get<double>();
}

Maybe anchorError(const json& summary) {
  double sum = 0;
  int count = 0;
  for (const json& anchor : summary.value("anchors", json::array())) {
    const Maybe error = number(anchor, "error");
    if (!error) continue;
    sum += *error;
    ++count;
  }
  return count > 0 ? Maybe(sum / count) : std::nullopt;
}

void readSummary(const json& summary, BatchResult* out) {
  out->ate_m = number(summary, "ate_posyaw_m");
  out->rotation_deg = number(summary, "ate_posyaw_deg");
  out->smoothed_m = number(summary, "ate_smoothed_posyaw_m");
  out->rpe_1s_m = number(summary, "rpe_1s_m");
  out->rpe_10m_m = number(summary, "rpe_10m_m");
  out->nees = number(summary, "nees_position");
  out->init_s = number(summary, "init_time_s");
  out->cpu_ms = number(summary, "cpu_ms_per_frame");
  out->anchor_m = anchorError(summary);
  const Maybe poses = number(summary, "poses"), frames = number(summary, "frames");
  if (poses && frames && *frames > 0) out->coverage = *poses / *frames;
  out->resets = summary.value("resets", 0L);
}

BatchResult readRun(const BatchRecording& recording, const BatchSetting& setting,
                    const std::vector<std::string>& folders) {
  BatchResult out;
  out.recording = recording.name();
  out.row = recording.row();
  out.setting = setting.name;
  out.seed = recording.seed;
  out.problem = "not run";
  for (const std::string& folder : folders) {
    const std::string run = batchRunFolder(folder, recording, setting);
    const json marker = readJson(run + "/batch.json");
    if (!marker.is_object()) continue;
    out.problem = marker.value("problem", "");
    out.run = run;
    if (!marker.value("ok", false)) continue;  // another folder may have it
    const json summary = readJson(run + "/summary.json");
    if (!summary.is_object()) {
      out.problem = "summary.json cannot be read";
      continue;
    }
    out.problem.clear();
    out.verdict = summary.value("verdict", "");
    readSummary(summary, &out);
    break;
  }
  return out;
}

/// Of one kind of number over runs; sorted, those without it left out.
std::vector<double> values(const std::vector<const BatchResult*>& runs, Maybe BatchResult::*field) {
  std::vector<double> out;
  for (const BatchResult* run : runs) {
    if (run->*field) out.push_back(*(run->*field));
  }
  std::sort(out.begin(), out.end());
  return out;
}

Maybe median(const std::vector<double>& sorted) {
  if (sorted.empty()) return std::nullopt;
  return quantileOfSorted(sorted, 0.5);
}

Maybe mean(const std::vector<double>& sorted) {
  if (sorted.empty()) return std::nullopt;
  double sum = 0;
  for (const double v : sorted) sum += v;
  return sum / static_cast<double>(sorted.size());
}

BatchCell cellOf(const std::string& setting, const std::vector<const BatchResult*>& runs) {
  BatchCell cell;
  cell.setting = setting;
  cell.runs = static_cast<int>(runs.size());
  for (const BatchResult* run : runs) {
    if (run->problem == "not run") {
      ++cell.missing;
    } else if (!run->problem.empty()) {
      ++cell.failed;
    }
  }
  const std::vector<double> ate = values(runs, &BatchResult::ate_m);
  cell.ate_median_m = median(ate);
  if (!ate.empty()) cell.ate_worst_m = ate.back();
  cell.smoothed_median_m = median(values(runs, &BatchResult::smoothed_m));
  cell.rpe_1s_m = median(values(runs, &BatchResult::rpe_1s_m));
  cell.rpe_10m_m = median(values(runs, &BatchResult::rpe_10m_m));
  cell.coverage = median(values(runs, &BatchResult::coverage));
  cell.init_s = median(values(runs, &BatchResult::init_s));
  cell.cpu_ms = median(values(runs, &BatchResult::cpu_ms));
  cell.nees = mean(values(runs, &BatchResult::nees));
  cell.anchor_m = median(values(runs, &BatchResult::anchor_m));
  return cell;
}

void markBest(BatchRow* row) {
  BatchCell* best = nullptr;
  for (BatchCell& cell : row->cells) {
    if (!cell.ate_median_m || cell.failed > 0) continue;
    if (best == nullptr || *cell.ate_median_m < *best->ate_median_m) best = &cell;
  }
  if (best != nullptr && row->cells.size() > 1) best->best = true;
}

}  // namespace

std::vector<BatchResult> readBatchResults(const BatchPlan& plan,
                                          const std::vector<std::string>& folders) {
  std::vector<BatchResult> out;
  for (const BatchRecording& recording : recordingsOf(plan)) {
    for (const BatchSetting& setting : plan.settings) {
      out.push_back(readRun(recording, setting, folders));
    }
  }
  return out;
}

std::vector<BatchRow> batchRows(const BatchPlan& plan, const std::vector<BatchResult>& results) {
  std::vector<BatchRow> rows;
  for (const BatchRecording& recording : recordingsOf(plan)) {
    const std::string name = recording.row();
    if (!rows.empty() && rows.back().name == name) continue;
    rows.push_back({name, recording.sequence->note, {}});
    for (const BatchSetting& setting : plan.settings) {
      std::vector<const BatchResult*> runs;
      for (const BatchResult& r : results) {
        if (r.row == name && r.setting == setting.name) runs.push_back(&r);
      }
      rows.back().cells.push_back(cellOf(setting.name, runs));
    }
    markBest(&rows.back());
  }
  return rows;
}

}  // namespace vir::app
