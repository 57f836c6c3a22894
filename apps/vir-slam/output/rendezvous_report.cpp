#include "output/rendezvous_report.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "output/rendezvous_output.h"
#include "vir/core/angles.h"
#include "vir/results/meeting_page.h"
#include "vir/results/transforms_json.h"

namespace vir::app {
namespace {

const team::RobotRecord& named(const std::vector<team::RobotRecord>& robots,
                               const std::string& name) {
  return *std::find_if(robots.begin(), robots.end(),
                       [&](const team::RobotRecord& r) { return r.name == name; });
}

std::vector<TableRow> rowsOf(const team::PairResult& pair, const std::optional<MergeError>& error) {
  const team::PairTransform& t = pair.transform;
  const team::TransformAnswer& a = t.answer;
  std::vector<TableRow> rows{{t.from + " in " + t.to, name(a.status), ""}};
  if (!a.reason.empty()) rows.push_back({"  why", a.reason, ""});
  rows.push_back({"  mutual ranges", std::to_string(pair.ranges.list.size()), ""});
  if (!a.solutions.empty()) {
    const team::TransformSolution& s = a.solutions[0];
    const Eigen::Vector4d sigma = s.covariance.diagonal().cwiseMax(0).cwiseSqrt();
    const auto& p = s.T_A_B.t_m;
    rows.push_back({"  yaw",
                    fixed(s.T_A_B.yaw_rad * 180 / kPi, 2) + " +- " + fixed(sigma[0] * 180 / kPi, 2),
                    "deg"});
    rows.push_back(
        {"  offset", fixed(p.x(), 3) + " " + fixed(p.y(), 3) + " " + fixed(p.z(), 3), "m"});
    rows.push_back({"    standard deviation",
                    fixed(sigma[1], 3) + " " + fixed(sigma[2], 3) + " " + fixed(sigma[3], 3), "m"});
    rows.push_back({"  ranges used, rejected",
                    std::to_string(s.used) + ", " + std::to_string(s.rejected), ""});
    rows.push_back({"  common anchors used", std::to_string(s.anchors_used), ""});
    if (a.places > 0) {
      rows.push_back({"  places seen by both, used",
                      std::to_string(a.places) + ", " + std::to_string(s.places_used), ""});
    }
  }
  rows.push_back(
      {"  first unique after", t.first_unique_s ? fixed(*t.first_unique_s, 1) : "-", "s"});
  if (error) {
    rows.push_back({"  merged trajectory, RMSE", fixed(error->merged_rmse_m, 3), "m"});
    rows.push_back(
        {"  error of the offset, yaw",
         fixed(error->offset_error_m, 3) + " m, " + fixed(error->yaw_error_deg, 2) + " deg", ""});
  }
  return rows;
}

nlohmann::ordered_json errorJson(const MergeError& e) {
  return {{"from", e.from},
          {"to", e.to},
          {"merged_rmse_m", e.merged_rmse_m},
          {"own_merged_rmse_m", e.own_merged_rmse_m},
          {"offset_error_m", e.offset_error_m},
          {"yaw_error_deg", e.yaw_error_deg}};
}

/// A loop of three robots.
std::vector<TableRow> rowsOf(const team::TransformLoop& loop) {
  const Vec3 offset = loop.error.tail<3>();
  return {{"loop " + loop.robots, loop.consistent ? "closes" : "CONTRADICTS ITSELF", ""},
          {"  closing error",
           fixed(offset.norm(), 3) + " m, " + fixed(std::abs(loop.error[0]) * 180 / kPi, 2) +
               " deg, chi2 " + fixed(loop.chi2, 1),
           ""}};
}

}  // namespace

std::vector<TableRow> writeMeeting(const results::ResultsFolder& folder,
                                   const team::Meeting& meeting, const MeetingOrigin& origin) {
  const team::MergedMap& map = meeting.map;
  std::vector<team::PairTransform> transforms;
  nlohmann::ordered_json summary;
  summary["robots"] = nlohmann::ordered_json::array();
  for (const team::RobotRecord& r : meeting.robots) summary["robots"].push_back(r.name);
  summary["merge_errors"] = nlohmann::ordered_json::array();
  std::vector<TableRow> rows;
  const auto append = [&](const std::vector<TableRow>& more) {
    rows.insert(rows.end(), more.begin(), more.end());
  };
  for (const team::PairResult& pair : meeting.pairs) {
    transforms.push_back(pair.transform);
    std::optional<MergeError> error;
    const auto& a = pair.transform.answer;
    if (a.status == team::TransformStatus::unique) {
      error = mergeError(named(meeting.robots, pair.transform.to),
                         named(meeting.robots, pair.transform.from), a.solutions[0].T_A_B, map);
      if (error) summary["merge_errors"].push_back(errorJson(*error));
    }
    append(rowsOf(pair, error));
  }
  for (const team::TransformLoop& loop : meeting.map.loops) append(rowsOf(loop));
  if (meeting.robots.size() > 2) rows.push_back({"common world", "that of " + map.root, ""});
  results::writeTextFile(folder.file("transforms.json"), results::transformsJson(transforms, map));
  summary["command"] = origin.command;
  summary["warnings"] = origin.warnings;
  summary["errors"] = origin.errors;
  results::writeTextFile(folder.file("summary.json"), summary.dump(2) + "\n");
  writeHistory(folder, meeting.pairs);
  writeMergedTrajectories(folder, map);
  writeMergedLandmarks(folder, map, meeting.robots);
  const evaluation::Figure figure = rendezvousFigure(map, meeting.robots);
  results::writeTextFile(folder.file("rendezvous.svg"), evaluation::toSvg(figure));
  results::MeetingPage page{
      meeting,         {},           evaluation::toSvgElement(figure), origin.command,
      origin.warnings, origin.errors};
  for (const team::RobotRecord& r : meeting.robots) {
    const std::string own = r.name + "/report.html";
    page.reports.push_back(std::filesystem::exists(folder.file(own)) ? own : "");
  }
  results::writeTextFile(folder.file("report.html"), results::meetingHtml(page));
  writeRendezvousScene(folder, map, meeting.robots);
  return rows;
}

}  // namespace vir::app
