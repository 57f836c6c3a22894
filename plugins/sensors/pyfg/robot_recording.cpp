#include "robot_recording.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>

#include "vir/core/settings.h"

namespace vir::pyfg {
namespace {

std::string listed(const std::set<char>& letters) {
  std::string text;
  for (const char c : letters) text += (text.empty() ? "" : ", ") + std::string(1, c);
  return text.empty() ? "none" : text;
}

char chooseRobot(const Graph& graph, const std::string& asked) {
  const std::set<char> robots = graph.robots();
  if (asked.empty() && robots.size() == 1) return *robots.begin();
  if (asked.size() == 1 && robots.count(asked[0]) > 0) return asked[0];
  const std::string there = "robots in " + graph.path + ": " + listed(robots);
  throw SettingsError({"settings", 0}, "pyfg", "robot",
                      asked.empty()
                          ? "say which robot to import (--set pyfg.robot=LETTER); " + there
                          : "there is no robot " + asked + "; " + there);
}

class Extraction {
 public:
  Extraction(const Graph& graph, const PyfgOptions& options, ProblemLog* log)
      : graph_(graph), options_(options), log_(log) {
    result_.robot = chooseRobot(graph, options.robot);
  }

  RobotRecording run() {
    if (options_.read_gt) addTruth();
    if (options_.read_odometry) addOdometry();
    for (const auto& r : graph_.ranges) addRange(r);
    for (const auto& [name, landmark] : graph_.landmarks) result_.landmarks.push_back(landmark);
    std::stable_sort(result_.events.begin(), result_.events.end(), before);
    result_.peers.assign(peers_.begin(), peers_.end());
    return std::move(result_);
  }

 private:
  static bool before(const Event& a, const Event& b) {
    return a.t != b.t ? a.t < b.t : a.what.index() < b.what.index();
  }

  void addTruth() {
    std::map<TimeNs, bool> seen;
    TimeNs newest = -1;
    for (const auto& [v, line] : graph_.vertices) {
      if (v.name.letter != result_.robot) continue;
      if (!seen.emplace(v.t, true).second) {
        log_->add("ground_truth_repeated_stamp", graph_.where(line),
                  toString(v.name) + " has the stamp of another pose; not used as ground truth");
        continue;
      }
      noteOrder("ground_truth_out_of_order", line, v.t, &newest);
      result_.events.push_back({v.t, TruePose{v.T_W_B}});
    }
  }

  void addOdometry() {
    const auto path = integrateOdometry(graph_, result_.robot, options_.planar, log_);
    for (const OdometryPose& pose : path) result_.events.push_back({pose.t, pose});
    if (path.empty()) log_->note("robot " + std::string(1, result_.robot) + " has no odometry");
  }

  /// Lines may come in any order, but time that goes back is worth a word.
  void noteOrder(const char* counter, long line, TimeNs t, TimeNs* newest) {
    if (t < *newest) {
      log_->add(counter, graph_.where(line),
                "the stamp lies before that of an earlier line; sorted");
    }
    *newest = std::max(*newest, t);
  }

  bool isLandmark(const Name& n) const {
    return graph_.landmarks.count(n) > 0 || graph_.robots().count(n.letter) == 0;
  }

  void addRange(const Numbered<RangeEdge>& r) {
    const RangeEdge& e = r.item;
    const bool a_mine = e.a.letter == result_.robot && !isLandmark(e.a);
    const bool b_mine = e.b.letter == result_.robot && !isLandmark(e.b);
    if (!a_mine && !b_mine) return log_->count("ranges_of_others");
    if (a_mine && b_mine) {
      return log_->add("range_within_robot", graph_.where(r.line),
                       "a range between two poses of one robot; not used");
    }
    const Name& other = a_mine ? e.b : e.a;
    if (isLandmark(other)) {
      addAnchorRange(r, other);
    } else {
      addPeerRange(r, other);
    }
  }

  void addAnchorRange(const Numbered<RangeEdge>& r, const Name& anchor) {
    if (!options_.read_ranges) return;
    const auto [it, fresh] = anchors_.emplace(anchor.number, anchor);
    if (!fresh && !(it->second == anchor)) {
      return log_->add("range_ambiguous_anchor", graph_.where(r.line),
                       toString(anchor) + " and " + toString(it->second) +
                           " would both be anchor " + std::to_string(anchor.number) +
                           "; the range is not used");
    }
    noteOrder("range_out_of_order", r.line, r.item.t, &newest_range_[anchor.letter]);
    result_.events.push_back(
        {r.item.t, AnchorRange{anchor.number, r.item.range_m, std::sqrt(r.item.variance)}});
  }

  void addPeerRange(const Numbered<RangeEdge>& r, const Name& other) {
    if (!options_.read_peer_ranges) return;
    peers_.insert(other.letter);
    noteOrder("range_out_of_order", r.line, r.item.t, &newest_range_[other.letter]);
    result_.events.push_back(
        {r.item.t, PeerRange{robotId(other.letter), r.item.range_m, std::sqrt(r.item.variance)}});
  }

  const Graph& graph_;
  const PyfgOptions& options_;
  ProblemLog* log_;
  RobotRecording result_;
  std::set<char> peers_;
  std::map<int, Name> anchors_;
  std::map<char, TimeNs> newest_range_;
};

}  // namespace

int robotId(char letter) { return std::toupper(static_cast<unsigned char>(letter)) - 'A'; }

RobotRecording extractRobot(const Graph& graph, const PyfgOptions& options, ProblemLog* log) {
  return Extraction(graph, options, log).run();
}

}  // namespace vir::pyfg
