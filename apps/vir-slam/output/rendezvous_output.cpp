#include "output/rendezvous_output.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "vir/core/angles.h"
#include "vir/evaluation/evaluate.h"
#include "vir/evaluation/figure_parts.h"
#include "vir/results/meeting_page.h"
#include "vir/results/scene_file.h"

namespace vir::app {
namespace {

std::string format(const char* pattern, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

Trajectory trajectoryOf(const team::RobotRecord& robot) {
  Trajectory out;
  for (const team::KnownPose& p : robot.poses) out.push_back({p.t, p.T_W_B});
  return out;
}

std::optional<Pose> truthFrom(const Trajectory& truth, const Trajectory& estimate) {
  if (truth.size() < 3 || estimate.size() < 3) return std::nullopt;
  try {
    return evaluation::evaluate(truth, estimate, evaluation::EvaluationOptions{}).transform.T_R_E;
  } catch (const evaluation::EvaluationError&) {
    return std::nullopt;
  }
}

/// Of a trajectory that T lays onto the truth.
std::optional<double> rmseIn(const Trajectory& truth, const Pose& T, const Trajectory& estimate) {
  Trajectory in_truth;
  for (const StampedPose& p : estimate) in_truth.push_back({p.t, T * p.T_W_B});
  evaluation::EvaluationOptions options;
  options.alignment = evaluation::Alignment::none;
  try {
    return evaluation::evaluate(truth, in_truth, options).ate_position_m.rmse;
  } catch (const evaluation::EvaluationError&) {
    return std::nullopt;
  }
}

/// Words in tables hold no commas.
std::string word(std::string text) {
  for (char& c : text) {
    if (c == ',' || c == '\n') c = ';';
  }
  return text;
}

}  // namespace

std::optional<MergeError> mergeError(const team::RobotRecord& a, const team::RobotRecord& b,
                                     const team::WorldTransform& T_A_B,
                                     const team::MergedMap& map) {
  const Trajectory own_a = trajectoryOf(a), own_b = trajectoryOf(b);
  const auto T_G_A = truthFrom(a.truth, own_a);
  const auto T_G_B = truthFrom(b.truth, own_b);
  const auto merged_a = map.trajectories.find(a.name), merged_b = map.trajectories.find(b.name);
  if (!T_G_A || !T_G_B || merged_a == map.trajectories.end() ||
      merged_b == map.trajectories.end()) {
    return std::nullopt;
  }
  const auto T_G_root = truthFrom(a.truth, merged_a->second);
  const auto merged = rmseIn(b.truth, *T_G_root, merged_b->second);
  const auto own = rmseIn(b.truth, *T_G_A * T_A_B.pose(), own_b);
  if (!merged || !own) return std::nullopt;
  const Pose truth = T_G_A->inverse() * *T_G_B;
  MergeError out;
  out.from = b.name;
  out.to = a.name;
  out.merged_rmse_m = *merged;
  out.own_merged_rmse_m = *own;
  out.offset_error_m = (T_A_B.t_m - truth.p).norm();
  out.yaw_error_deg = std::abs(team::wrapAngle(T_A_B.yaw_rad - yawOf(truth.R()))) * 180 / kPi;
  return out;
}

void writeMergedTrajectories(const results::ResultsFolder& folder, const team::MergedMap& map) {
  for (const auto& [name, trajectory] : map.trajectories) {
    results::OutputFile file(folder.file("trajectory_" + name + ".tum"));
    evaluation::writeTum(file.stream(), trajectory);
    file.close();
  }
}

void writeMergedLandmarks(const results::ResultsFolder& folder, const team::MergedMap& map,
                          const std::vector<team::RobotRecord>& robots) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const auto T = map.T_root.find(robots[i].name);
    if (T == map.T_root.end()) continue;
    const evaluation::Color c = evaluation::figureColor(results::robotColor(i));
    for (const Landmark& l : robots[i].landmarks) {
      if (!l.p_W.allFinite()) continue;
      const Vec3 p = T->second * l.p_W;
      lines.push_back(format("%.4f %.4f %.4f %d %d %d", p.x(), p.y(), p.z(), c.r, c.g, c.b));
    }
  }
  results::OutputFile file(folder.file("landmarks.ply"));
  file.line("ply\nformat ascii 1.0\nelement vertex " + std::to_string(lines.size()));
  file.line("property float x\nproperty float y\nproperty float z");
  file.line("property uchar red\nproperty uchar green\nproperty uchar blue\nend_header");
  for (const std::string& line : lines) file.line(line);
  file.close();
}

void writeHistory(const results::ResultsFolder& folder,
                  const std::vector<team::PairResult>& pairs) {
  results::OutputFile file(folder.file("transforms_over_time.csv"));
  file.line(
      "from,to,since_first_s,status,ranges,used,rejected,anchors_used,yaw_rad,x_m,y_m,z_m,"
      "sigma_yaw_rad,sigma_x_m,sigma_y_m,sigma_z_m,margin,needed_margin,reason");
  for (const team::PairResult& pair : pairs) {
    for (const team::PairMoment& m : pair.history) {
      const team::TransformAnswer& a = m.answer;
      std::string line = pair.transform.from + "," + pair.transform.to;
      line += format(",%.3f,%s,%d", m.since_first_s, name(a.status), a.ranges);
      if (a.solutions.empty()) {
        line += ",,,,,,,,,,,";
      } else {
        const team::TransformSolution& s = a.solutions[0];
        const Eigen::Vector4d sigma = s.covariance.diagonal().cwiseMax(0).cwiseSqrt();
        line += format(",%d,%d,%d,%.6f,%.4f,%.4f,%.4f,%.6f,%.4f,%.4f,%.4f", s.used, s.rejected,
                       s.anchors_used, s.T_A_B.yaw_rad, s.T_A_B.t_m.x(), s.T_A_B.t_m.y(),
                       s.T_A_B.t_m.z(), sigma[0], sigma[1], sigma[2], sigma[3]);
      }
      line += std::isfinite(a.margin) ? format(",%.2f", a.margin) : ",";
      line += format(",%.2f,", a.needed_margin) + word(a.reason);
      file.line(line);
    }
  }
  file.close();
}

namespace {

constexpr TimeNs kNeverCut = INT64_MAX;
constexpr std::size_t kMostPoints = 4000;
constexpr double kSceneGap = 4;  // [m], between worlds that are shown apart

Trajectory thinned(const Trajectory& path) {
  const std::size_t n = path.size() / kMostPoints + 1;
  Trajectory out;
  for (std::size_t i = 0; i < path.size(); i += n) out.push_back(path[i]);
  return out;
}

void addPath(const Trajectory& path, evaluation::Color color, evaluation::Panel* panel) {
  panel->curves.push_back({color, 1.6, evaluation::pathStrokes(thinned(path), 0, 1, kNeverCut)});
  if (path.empty()) return;
  const Vec3& p = path.front().T_W_B.p;
  panel->marks.push_back({{p.x(), p.y()}, color, 4, evaluation::Mark::Shape::dot, ""});
}

void addAnchors(const team::RobotRecord& robot, const team::WorldTransform& T,
                evaluation::Panel* panel) {
  if (robot.anchors.empty()) return;
  for (const Anchor& a : robot.anchors.back().anchors) {
    if (!a.has_position || !a.p_W.allFinite()) continue;
    const Vec3 p = T * a.p_W;
    panel->marks.push_back({{p.x(), p.y()},
                            evaluation::figureColor(results::kAnchorColor),
                            5,
                            evaluation::Mark::Shape::ring,
                            "anchor " + std::to_string(a.id)});
  }
}

/// Smallest and largest coordinates of a path.
std::pair<Vec3, Vec3> extentOf(const Trajectory& path) {
  std::pair<Vec3, Vec3> out(Vec3::Constant(1e300), Vec3::Constant(-1e300));
  for (const StampedPose& p : path) {
    out.first = out.first.cwiseMin(p.T_W_B.p);
    out.second = out.second.cwiseMax(p.T_W_B.p);
  }
  return out;
}

}  // namespace

void writeRendezvousScene(const results::ResultsFolder& folder, const team::MergedMap& map,
                          const std::vector<team::RobotRecord>& robots) {
  std::vector<results::SceneRobot> scene;
  double lowest = 0;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const team::RobotRecord& robot = robots[i];
    const auto T = map.T_root.find(robot.name);
    const auto path = map.trajectories.find(robot.name);
    if (T == map.T_root.end() || path == map.trajectories.end() || path->second.empty()) continue;
    results::SceneRobot merged{"robot " + robot.name,
                               evaluation::figureColor(results::robotColor(i)),
                               T->second.pose(),
                               {},
                               {},
                               {}};
    // The path is in the common world already.
    const Pose back = merged.T.inverse();
    for (const StampedPose& p : path->second) merged.path.push_back({p.t, back * p.T_W_B});
    if (!robot.anchors.empty()) merged.anchors = robot.anchors.back().anchors;
    merged.landmarks = robot.landmarks;
    lowest = std::min(lowest, extentOf(path->second).first.z());
    scene.push_back(std::move(merged));
  }
  double from = 0;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const team::RobotRecord& robot = robots[i];
    results::SceneRobot own{robot.name + " in its own world",
                            evaluation::figureColor(results::robotColor(i)),
                            Pose(),
                            trajectoryOf(robot),
                            {},
                            {}};
    if (own.path.empty()) continue;
    const auto [low, high] = extentOf(own.path);
    own.T.p = Vec3(from - low.x(), 0, lowest - high.z() - kSceneGap);
    from += high.x() - low.x() + kSceneGap;
    if (!robot.anchors.empty()) own.anchors = robot.anchors.back().anchors;
    scene.push_back(std::move(own));
  }
  results::writeScene(folder.file("scene.3Dscene"), scene);
}

evaluation::Figure rendezvousFigure(const team::MergedMap& map,
                                    const std::vector<team::RobotRecord>& robots) {
  evaluation::Figure figure;
  figure.width = 1200;
  figure.title = "Rendezvous";
  figure.subtitle = "above: all in the world of " + map.root +
                    "; below: each robot in its own (dot: where it starts, ring: anchor)";
  figure.legend = {20, 64};
  evaluation::Panel merged;
  merged.title = "In the world of " + map.root;
  merged.equal_aspect = true;
  merged.x_label = "x [m]";
  merged.y_label = "y [m]";
  const std::size_t n = robots.size();
  const double gap = 90, width = (1200.0 - 40) / static_cast<double>(n) - gap;
  std::vector<evaluation::Panel> own;
  for (std::size_t i = 0; i < n; ++i) {
    const evaluation::Color color = evaluation::figureColor(results::robotColor(i));
    figure.entries.push_back({"robot " + robots[i].name, color});
    evaluation::Panel panel;
    panel.title = "Robot " + robots[i].name + " in its own world";
    panel.equal_aspect = true;
    panel.x_label = "x [m]";
    panel.y_label = "y [m]";
    addPath(trajectoryOf(robots[i]), color, &panel);
    addAnchors(robots[i], {}, &panel);
    own.push_back(panel);
    const auto T = map.T_root.find(robots[i].name);
    const auto path = map.trajectories.find(robots[i].name);
    if (T == map.T_root.end() || path == map.trajectories.end()) continue;
    addPath(path->second, color, &merged);
    addAnchors(robots[i], T->second, &merged);
  }
  const double top = 64 + 20 * static_cast<double>(n) + 40;
  merged.corner = {80, top};
  merged.size = {1090, 480};
  for (std::size_t i = 0; i < n; ++i) {
    own[i].corner = {80 + static_cast<double>(i) * (width + gap), top + 480 + 100};
    own[i].size = {width, 360};
  }
  figure.panels.push_back(merged);
  figure.panels.insert(figure.panels.end(), own.begin(), own.end());
  figure.height = top + 480 + 100 + 360 + 60;
  return figure;
}

}  // namespace vir::app
