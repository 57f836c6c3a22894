#include "output/run_table.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "output/console.h"
#include "robots/peer_run.h"

namespace vir::app {
namespace {

/// One row with the position, one with the error where the truth is known.
void addAnchorRows(const results::AnchorResult& anchor, std::vector<TableRow>* rows) {
  const Anchor& a = anchor.estimate;
  const std::string title = "anchor " + anchor.title();
  if (!a.has_position) {
    rows->push_back({title + " (" + name(a.state) + ")", "-", "m"});
    return;
  }
  const Vec3 sigma = a.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  rows->push_back({title + " (" + name(a.state) + ")",
                   fixed(a.p_W.x(), 3) + " " + fixed(a.p_W.y(), 3) + " " + fixed(a.p_W.z(), 3),
                   "m"});
  rows->push_back({"  standard deviation",
                   fixed(sigma.x(), 3) + " " + fixed(sigma.y(), 3) + " " + fixed(sigma.z(), 3),
                   "m"});
  if (anchor.error_m) {
    rows->push_back({"  error (horizontal)",
                     fixed(*anchor.error_m, 3) + " (" + fixed(*anchor.error_horizontal_m, 3) + ")",
                     "m"});
  }
}

void addRangeRows(const results::RunSummary& s, std::vector<TableRow>* rows) {
  if (s.anchors.empty() &&
      s.ranges_accepted + s.ranges_collected + s.ranges_rejected + s.ranges_before_start == 0)
    return;
  const auto found =
      std::count_if(s.anchors.begin(), s.anchors.end(),
                    [](const results::AnchorResult& a) { return a.estimate.has_position; });
  rows->push_back(
      {"anchors found", std::to_string(found) + " of " + std::to_string(s.anchors.size()), ""});
  for (const results::AnchorResult& a : s.anchors) addAnchorRows(a, rows);
  if (s.survey) {
    const auto used = std::count_if(s.survey->anchors.begin(), s.survey->anchors.end(),
                                    [](const SurveyedResult& a) { return a.used; });
    rows->push_back({"survey of the anchors",
                     std::string(name(s.survey->status)) + ", " + std::to_string(used) + " of " +
                         std::to_string(s.survey->anchors.size()) + " hold",
                     ""});
  }
  rows->push_back({"ranges used", std::to_string(s.ranges_accepted), ""});
  rows->push_back({"ranges before there was an anchor", std::to_string(s.ranges_collected), ""});
  rows->push_back({"ranges before the first pose", std::to_string(s.ranges_before_start), ""});
  rows->push_back({"ranges rejected", std::to_string(s.ranges_rejected), ""});
}

constexpr std::size_t kWarningsShown = 5;

}  // namespace

void printRunTable(const results::RunSummary& s, const std::string& folder) {
  const auto optional = [](const std::optional<double>& v, int decimals) {
    return v ? fixed(*v, decimals) : std::string("-");
  };
  std::vector<TableRow> rows{
      {"verdict", name(s.verdict), ""},
      {"images or odometry poses", std::to_string(s.frames), ""},
      {"poses", std::to_string(s.poses), ""},
      {"first pose after", optional(s.init_time_s, 2), "s"},
      {"duration", fixed(s.duration_s, 2), "s"},
      {"path", fixed(s.path_m, 2), "m"},
  };
  if (s.in_map_s) rows.push_back({"in the frame of the map after", fixed(*s.in_map_s, 2), "s"});
  if (s.ate_posyaw_m) {
    rows.push_back({"ATE (position + yaw aligned)", fixed(*s.ate_posyaw_m, 4), "m"});
    rows.push_back({"ATE rotation (same alignment)", optional(s.ate_posyaw_deg, 3), "deg"});
  }
  if (s.ate_smoothed_posyaw_m) {
    rows.push_back({"ATE of the smoothed keyframes", fixed(*s.ate_smoothed_posyaw_m, 4), "m"});
  }
  addRangeRows(s, &rows);
  addPeerRows(s.peers, &rows);
  if (s.loops) rows.push_back({"places seen twice", std::to_string(s.loops->first), ""});
  rows.push_back({"resets", std::to_string(s.resets), ""});
  rows.push_back({"CPU per image", fixed(s.cpu_ms_per_frame, 2), "ms"});
  rows.push_back({"run time", fixed(s.wall_s, 2), "s"});
  rows.push_back({"peak memory", fixed(s.peak_rss_mb, 0), "MB"});
  rows.push_back({"warnings", std::to_string(s.warnings.size()), ""});
  printTable(rows);
  for (const std::string& doubt : s.doubts) std::printf("doubt: %s\n", doubt.c_str());
  // Also those that were said while it ran: they have scrolled away.
  for (std::size_t k = 0; k < s.warnings.size() && k < kWarningsShown; ++k) {
    std::printf("warning: %s\n", s.warnings[k].c_str());
  }
  if (s.warnings.size() > kWarningsShown) {
    std::printf("%zu more warnings: summary.json, report.html\n",
                s.warnings.size() - kWarningsShown);
  }
  for (const results::AnchorResult& a : s.anchors) {
    if (a.estimate.advice.empty()) continue;
    std::printf("anchor %s: %s\n", a.title().c_str(), a.estimate.advice.c_str());
  }
  std::printf("Results in %s\n", folder.c_str());
}

}  // namespace vir::app
