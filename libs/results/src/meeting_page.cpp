#include "vir/results/meeting_page.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "json_columns.h"
#include "page_files.h"
#include "page_frame.h"
#include "vir/core/angles.h"
#include "vir/core/markup.h"

namespace vir::results {
namespace {

using csv::format;

/// The first pose of all: 0 s of the page.
TimeNs startOf(const team::Meeting& meeting) {
  std::optional<TimeNs> first;
  for (const auto& [name, path] : meeting.map.trajectories) {
    if (!path.empty()) first = std::min(first.value_or(path.front().t), path.front().t);
  }
  return first.value_or(0);
}

std::string robotsJson(const team::Meeting& meeting, TimeNs start) {
  std::string out = "[";
  for (std::size_t i = 0; i < meeting.robots.size(); ++i) {
    const std::string& name = meeting.robots[i].name;
    const auto path = meeting.map.trajectories.find(name);
    if (path == meeting.map.trajectories.end()) continue;
    if (out.size() > 1) out += ",";
    out += "{\"name\":" + jsonText(name) + ",\"color\":\"c" + std::to_string(robotColor(i)) +
           "\",\"path\":" + pathJson(thinnedForPage(path->second), start) + "}";
  }
  return out + "]";
}

/// Anchors as each robot knows them, in the common world.
std::string anchorsJson(const team::Meeting& meeting) {
  std::string out = "[";
  for (const team::RobotRecord& robot : meeting.robots) {
    const auto T = meeting.map.T_root.find(robot.name);
    if (T == meeting.map.T_root.end() || robot.anchors.empty()) continue;
    const Mat3 R = T->second.pose().R();
    for (Anchor a : robot.anchors.back().anchors) {
      a.p_W = T->second * a.p_W;
      a.mirror_p_W = T->second * a.mirror_p_W;
      a.covariance = R * a.covariance * R.transpose();
      out += (out.size() > 1 ? "," : "") + anchorJson(a, nullptr);
    }
  }
  return out + "]";
}

std::vector<Landmark> allLandmarks(const team::Meeting& meeting) {
  std::vector<Landmark> out;
  for (const team::RobotRecord& robot : meeting.robots) {
    const auto T = meeting.map.T_root.find(robot.name);
    if (T == meeting.map.T_root.end()) continue;
    for (const Landmark& l : robot.landmarks) out.push_back({l.id, T->second * l.p_W});
  }
  return out;
}

std::string pairJson(const team::PairResult& pair, TimeNs start) {
  const TimeNs first = pair.ranges.list.empty() ? start : pair.ranges.list.front().range.t;
  std::vector<team::PairMoment> moments;
  for (const team::PairMoment& m : pair.history) {
    if (!m.answer.solutions.empty()) moments.push_back(m);
  }
  moments = thinnedForPage(moments);
  std::string out = "{";
  const auto add = [&](const char* name, int decimals, auto value) {
    addColumn(
        name, moments.size(), decimals,
        [&](std::size_t i) { return value(moments[i].answer.solutions[0]); }, &out);
  };
  using Solution = team::TransformSolution;
  addColumn(
      "t", moments.size(), 2,
      [&](std::size_t i) { return toSeconds(first - start) + moments[i].since_first_s; }, &out);
  add("yaw", 2, [](const Solution& s) { return kDegPerRad * s.T_A_B.yaw_rad; });
  add("syaw", 3,
      [](const Solution& s) { return kDegPerRad * std::sqrt(std::max(0.0, s.covariance(0, 0))); });
  static constexpr const char* kAxes[] = {"x", "y", "z"};
  static constexpr const char* kSigmas[] = {"sx", "sy", "sz"};
  for (int k = 0; k < 3; ++k) {
    add(kAxes[k], 3, [&](const Solution& s) { return s.T_A_B.t_m[k]; });
    add(kSigmas[k], 3,
        [&](const Solution& s) { return std::sqrt(std::max(0.0, s.covariance(k + 1, k + 1))); });
  }
  addColumn(
      "margin", moments.size(), 1, [&](std::size_t i) { return moments[i].answer.margin; }, &out);
  return out + ",\"name\":" + jsonText(pair.transform.from + " to " + pair.transform.to) + "}";
}

/// When the verdict on a pair changed.
std::string eventsJson(const team::Meeting& meeting, TimeNs start) {
  std::string out = "[";
  for (const team::PairResult& pair : meeting.pairs) {
    const TimeNs first = pair.ranges.list.empty() ? start : pair.ranges.list.front().range.t;
    std::string last;
    for (const team::PairMoment& m : pair.history) {
      const std::string status = name(m.answer.status);
      if (status == last) continue;
      last = status;
      const std::string text = pair.transform.from + " to " + pair.transform.to + ": " + status +
                               (m.answer.reason.empty() ? "" : ", " + m.answer.reason);
      out += (out.size() > 1 ? ",[" : "[") +
             jsonNumber(toSeconds(first - start) + m.since_first_s, 2) + "," + jsonText(text) +
             (m.answer.status == team::TransformStatus::inconsistent ? ",true]" : ",false]");
    }
  }
  return out + "]";
}

std::string pairTable(const team::Meeting& meeting) {
  std::string t =
      "<table>\n<tr><th>transform</th><th></th><th class=\"n\">yaw [deg]</th>"
      "<th class=\"n\">offset [m]</th><th class=\"n\">standard deviations [deg, m]</th>"
      "<th class=\"n\">unique after [s]</th><th></th></tr>\n";
  for (const team::PairResult& pair : meeting.pairs) {
    const team::TransformAnswer& a = pair.transform.answer;
    const auto cell = [](const std::string& text) {
      return "<td class=\"n\">" + escapedMarkup(text) + "</td>";
    };
    t += "<tr><td>" + escapedMarkup(pair.transform.from + " to " + pair.transform.to) +
         "</td><td>" + name(a.status) + "</td>";
    if (a.solutions.empty()) {
      t += cell("-") + cell("-") + cell("-");
    } else {
      const team::TransformSolution& s = a.solutions[0];
      const Eigen::Vector4d sigma = s.covariance.diagonal().cwiseMax(0).cwiseSqrt();
      t += cell(format("%.2f", kDegPerRad * s.T_A_B.yaw_rad)) +
           cell(format("%.3f, %.3f, %.3f", s.T_A_B.t_m.x(), s.T_A_B.t_m.y(), s.T_A_B.t_m.z())) +
           cell(format("%.2f, %.3f, %.3f, %.3f", kDegPerRad * sigma[0], sigma[1], sigma[2],
                       sigma[3]));
    }
    const auto& unique = pair.transform.first_unique_s;
    t += cell(unique ? format("%.1f", *unique) : "-") + "<td>" + escapedMarkup(a.reason) +
         "</td></tr>\n";
  }
  return t + "</table>\n";
}

std::string robotTable(const MeetingPage& page) {
  const team::Meeting& meeting = page.meeting;
  std::string t =
      "<table>\n<tr><th>robot</th><th class=\"n\">poses</th><th>placed</th><th></th></tr>\n";
  for (std::size_t i = 0; i < meeting.robots.size(); ++i) {
    const team::RobotRecord& robot = meeting.robots[i];
    const bool placed = meeting.map.T_root.count(robot.name) > 0;
    const std::string report = i < page.reports.size() ? page.reports[i] : "";
    t += "<tr><td>" + escapedMarkup(robot.name) + "</td><td class=\"n\">" +
         std::to_string(robot.poses.size()) + "</td><td" + (placed ? ">yes" : " class=\"bad\">no") +
         (robot.damaged ? ", recording damaged" : "") + "</td><td>" +
         (report.empty() ? "" : "<a href=\"" + escapedMarkup(report) + "\">its own run</a>") +
         "</td></tr>\n";
  }
  return t + "</table>\n";
}

}  // namespace

std::size_t robotColor(std::size_t i) {
  constexpr std::size_t kColors[] = {0, 2, 4, 5};
  return kColors[i % 4];
}

std::string meetingHtml(const MeetingPage& page) {
  const team::Meeting& meeting = page.meeting;
  const TimeNs start = startOf(meeting);
  std::string said;
  if (!page.errors.empty()) said += "<div class=\"bad\">" + listHtml(page.errors) + "</div>\n";
  if (!page.warnings.empty()) said += "<h2>Warnings</h2>\n" + listHtml(page.warnings);
  const std::string content = "<h1>Robots in the world of " + escapedMarkup(meeting.map.root) +
                              "</h1>\n" + said + "<div class=\"scroll\">" + robotTable(page) +
                              pairTable(meeting) +
                              "</div>\n<div id=\"live\"></div>\n<div id=\"still\">\n" +
                              page.still_svg + "</div>\n" + originHtml(page.command, start);
  std::string json = "{\"robots\":" + robotsJson(meeting, start) +
                     ",\"anchors\":" + anchorsJson(meeting) +
                     ",\"landmarks\":" + pointsJson(allLandmarks(meeting)) + ",\"pairs\":[";
  for (const team::PairResult& pair : meeting.pairs) {
    if (json.back() != '[') json += ",";
    json += pairJson(pair, start);
  }
  json += "],\"events\":" + eventsJson(meeting, start) + "}";
  return filledPage({"vir-slam: robots in the world of " + meeting.map.root, content,
                     insideScript(json), page::meeting_js});
}

}  // namespace vir::results
