#include "report_html.h"

#include <cmath>

#include "csv_text.h"
#include "page_files.h"
#include "page_frame.h"
#include "vir/core/angles.h"
#include "vir/core/markup.h"

namespace vir::results {
namespace {

using csv::format;

std::string number(double v, int decimals) {
  return std::isfinite(v) ? format("%.*f", decimals, v) : std::string("-");
}

std::string number(const std::optional<double>& v, int decimals) {
  return v ? number(*v, decimals) : std::string("-");
}

std::string row(const std::string& name, const std::string& value, const char* unit = "") {
  return "<tr><td>" + escapedMarkup(name) + "</td><td class=\"n\">" + escapedMarkup(value) +
         "</td><td>" + unit + "</td></tr>\n";
}

std::string summaryTable(const RunSummary& s) {
  std::string t = "<table>\n";
  t += row("frames (images, or odometry poses)", std::to_string(s.frames));
  t += row("poses", std::to_string(s.poses));
  t += row("first pose after", number(s.init_time_s, 2), "s");
  if (s.in_map_s) t += row("in the frame of the map after", number(s.in_map_s, 2), "s");
  t += row("duration", number(s.duration_s, 2), "s");
  t += row("path", number(s.path_m, 2), "m");
  if (s.ate_posyaw_m) {
    t +=
        row("ATE of the causal trajectory, position + yaw aligned", number(s.ate_posyaw_m, 4), "m");
    t += row("ATE of its attitude", number(s.ate_posyaw_deg, 3), "deg");
  }
  if (s.ate_smoothed_posyaw_m) {
    t += row("ATE of the smoothed keyframes", number(s.ate_smoothed_posyaw_m, 4), "m");
  }
  if (s.rpe_1s_m) {
    t += row("relative error over 1 s, RMS", number(s.rpe_1s_m, 4), "m");
    t += row("of its attitude", number(s.rpe_1s_deg, 3), "deg");
  }
  if (s.rpe_10m_m) t += row("relative error over 10 m, RMS", number(s.rpe_10m_m, 4), "m");
  if (s.nees_position) {
    t += row("NEES of the position per axis (1: as sure as it should be; above: too sure)",
             number(s.nees_position, 2));
  }
  if (s.ranges_accepted + s.ranges_collected + s.ranges_rejected + s.ranges_before_start > 0) {
    t += row("ranges used", std::to_string(s.ranges_accepted));
    t += row("ranges before there was an anchor", std::to_string(s.ranges_collected));
    t += row("ranges before the first pose", std::to_string(s.ranges_before_start));
    t += row("ranges rejected", std::to_string(s.ranges_rejected));
  }
  if (s.loops) {
    t += row("places seen twice", std::to_string(s.loops->first) + " (" +
                                      std::to_string(s.loops->second) + " rejected)");
  }
  t += row("resets", std::to_string(s.resets));
  t += row("CPU per frame", number(s.cpu_ms_per_frame, 2), "ms");
  t += row("run time", number(s.wall_s, 1), "s");
  t += row("warnings", std::to_string(s.warnings.size()));
  return t + "</table>\n";
}

std::string cell(const std::string& text, bool numeric = true) {
  return (numeric ? "<td class=\"n\">" : "<td>") + escapedMarkup(text) + "</td>";
}

std::string vectorText(const Vec3& v) {
  return number(v.x(), 3) + ", " + number(v.y(), 3) + ", " + number(v.z(), 3);
}

std::string anchorTable(const std::vector<AnchorResult>& anchors) {
  std::string t =
      "<table>\n<tr><th>anchor</th><th>state</th><th class=\"n\">position [m]</th>"
      "<th class=\"n\">standard deviation [m]</th><th class=\"n\">bias [m]</th>"
      "<th class=\"n\">ranges used</th><th class=\"n\">rejected</th>"
      "<th class=\"n\">error (horizontal) [m]</th><th></th></tr>\n";
  for (const AnchorResult& anchor : anchors) {
    const Anchor& a = anchor.estimate;
    const Vec3 sigma = a.covariance.diagonal().cwiseMax(0).cwiseSqrt();
    std::string advice = a.advice;
    if (a.state == AnchorState::mirror_open) {
      advice = "or at " + vectorText(a.mirror_p_W) + (advice.empty() ? "" : "; ") + advice;
    }
    t += "<tr>" + cell(anchor.title(), false) + cell(name(a.state), false) +
         cell(a.has_position ? vectorText(a.p_W) : "-") +
         cell(a.has_position ? vectorText(sigma) : "-") +
         cell(number(a.bias_m, 3) + " +- " + number(a.bias_sigma_m, 3)) +
         cell(std::to_string(a.ranges_used)) + cell(std::to_string(a.ranges_rejected)) +
         cell(anchor.error_m
                  ? number(anchor.error_m, 3) + " (" + number(anchor.error_horizontal_m, 3) + ")"
                  : "-") +
         cell(advice, false) + "</tr>\n";
  }
  return t + "</table>\n";
}

std::string peerTable(const std::vector<team::PeerResult>& peers) {
  std::string t =
      "<table>\n<tr><th>robot</th><th>its world in this one</th><th class=\"n\">yaw [deg]</th>"
      "<th class=\"n\">offset [m]</th><th class=\"n\">standard deviation [m]</th>"
      "<th class=\"n\">unique after [s]</th><th class=\"n\">ranges</th>"
      "<th class=\"n\">without broadcast</th><th></th></tr>\n";
  for (const team::PeerResult& peer : peers) {
    const team::TransformAnswer& a = peer.transform.answer;
    const bool solved = !a.solutions.empty();
    const team::TransformSolution s = solved ? a.solutions[0] : team::TransformSolution();
    const Vec3 sigma = s.covariance.diagonal().tail<3>().cwiseMax(0).cwiseSqrt();
    t += "<tr>" + cell(std::to_string(peer.id), false) + cell(name(a.status), false) +
         cell(solved ? number(s.T_A_B.yaw_rad * 180 / kPi, 2) : "-") +
         cell(solved ? vectorText(s.T_A_B.t_m) : "-") + cell(solved ? vectorText(sigma) : "-") +
         cell(number(peer.transform.first_unique_s, 1)) + cell(std::to_string(peer.ranges)) +
         cell(std::to_string(peer.without_broadcast)) + cell(a.reason, false) + "</tr>\n";
  }
  return t + "</table>\n";
}

std::string picture(const evaluation::Figure& figure) {
  return figure.panels.empty() ? std::string() : evaluation::toSvgElement(figure);
}

/// What can be said of the run in a few lines.
std::string heading(const RunSummary& s) {
  std::string page = "<h1>" + escapedMarkup(s.rawlog) + "</h1>\n<p>Estimator <b>" +
                     escapedMarkup(s.estimator) + "</b></p>\n";
  page += std::string("<p class=\"") + (s.verdict == Verdict::good ? "good" : "bad") +
          "\">Verdict: <b>" + name(s.verdict) + "</b></p>\n";
  if (!s.doubts.empty()) page += listHtml(s.doubts);
  if (!s.error.empty())
    page += "<p class=\"bad\">The run ended early: " + escapedMarkup(s.error) + "</p>\n";
  if (s.interrupted) page += "<p class=\"bad\">The run was interrupted.</p>\n";
  if (s.poses == 0) {
    page += "<p class=\"bad\">No pose at all. " + escapedMarkup(s.longest_wait_reason) + "</p>\n";
  }
  return page;
}

/// The pictures that stand still: for who has no script, and until it has run.
std::string stillPictures(const RunSummary& s, const RunPictures& pictures) {
  std::string page = "<div id=\"live\"></div>\n<div id=\"still\">\n<h2>Pictures</h2>\n";
  if (s.poses > 0) page += picture(mapFigure(pictures));
  page += picture(rangesFigure(pictures)) + picture(errorFigure(pictures)) +
          picture(calibrationFigure(pictures)) + picture(cpuFigure(pictures));
  return page + "</div>\n";
}

std::string tables(const RunSummary& s) {
  std::string page = "<h2>Summary</h2>\n<div class=\"scroll\">" + summaryTable(s) + "</div>\n";
  const auto add = [&](const char* title, const std::string& table) {
    page += std::string("<h2>") + title + "</h2>\n<div class=\"scroll\">" + table + "</div>\n";
  };
  if (!s.anchors.empty()) add("Anchors", anchorTable(s.anchors));
  if (!s.peers.empty()) add("Other robots", peerTable(s.peers));
  if (!s.warnings.empty()) add("Warnings", listHtml(s.warnings));
  if (s.counters.empty()) return page;
  std::string counted = "<table>\n";
  for (const auto& [name, count] : s.counters) counted += row(name, std::to_string(count));
  add("Counted", counted + "</table>\n");
  return page;
}

}  // namespace

std::string reportHtml(const RunSummary& s, const ReportData& data) {
  const std::string content = heading(s) + stillPictures(s, data.pictures) + tables(s) +
                              originHtml(s.command, data.pictures.first_frame);
  return filledPage({"vir-slam: " + s.rawlog, content, reportJson(s, data), page::run_js});
}

}  // namespace vir::results
