#include "graph.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "input_error.h"
#include "text_fields.h"

namespace vir::pyfg {
namespace {

/// Landmarks bear this letter unless poses do.
constexpr char kLandmarkLetter = 'L';

class GraphReader {
 public:
  GraphReader(const std::string& path, ProblemLog* log) : lines_(path), log_(log) {
    graph_.path = path;
  }

  Graph read() {
    std::string text;
    while (lines_.next(&text)) readLine(text);
    if (lines_.failed()) {
      log_->add("file_read_error", lines_.where(), "the file cannot be read further");
    }
    if (graph_.vertices.empty() && graph_.motions.empty() && graph_.ranges.empty()) {
      throw InputError(graph_.path + ": no line of it is a pose, a motion or a range in PyFG text" +
                       firstProblem());
    }
    dropRangesOfUnknownPoses();
    return std::move(graph_);
  }

 private:
  void readLine(const std::string& text) {
    if (lines_.lastLineOpen()) {
      log_->add("line_cut", lines_.where(),
                "the file ends without a line break: its last line may be cut and is not used");
      return;
    }
    Line line;
    LineFault fault;
    if (!parseLine(text, &line, &fault)) {
      log_->add(fault.kind, lines_.where(), fault.text);
      return;
    }
    std::visit([this](const auto& item) { add(item); }, line);
  }

  template <typename Key>
  bool isNew(std::set<Key>* seen, const Key& key, const char* counter, const std::string& what) {
    if (seen->insert(key).second) return true;
    log_->add(counter, lines_.where(), what + " is there already; this line is not used");
    return false;
  }

  void add(const Vertex& v) {
    if (!isNew(&seen_vertices_, v.name, "vertex_repeated", "pose " + toString(v.name))) return;
    graph_.vertices.push_back({v, lines_.lineNumber()});
  }

  void add(const MotionEdge& e) {
    const std::string what = "the motion from " + toString(e.from) + " to " + toString(e.to);
    if (!isNew(&seen_motions_, {e.from, e.to}, "motion_repeated", what)) return;
    if (!e.covariance_usable) {
      log_->add("motion_bad_covariance", lines_.where(),
                what + " has a matrix that is no covariance; the motion is used without");
    }
    graph_.motions.push_back({e, lines_.lineNumber()});
  }

  void add(const RangeEdge& e) {
    const std::string what = "a range of this time from " + toString(e.a) + " to " + toString(e.b);
    if (!isNew(&seen_ranges_, {e.t, e.a, e.b}, "range_repeated", what)) return;
    graph_.ranges.push_back({e, lines_.lineNumber()});
  }

  void add(const Landmark& l) {
    if (!graph_.landmarks.emplace(l.name, l).second) {
      log_->add("landmark_repeated", lines_.where(),
                "landmark " + toString(l.name) + " is there already; this line is not used");
    }
  }

  void dropRangesOfUnknownPoses() {
    std::set<Name> known = seen_vertices_;
    for (const auto& [e, line] : graph_.motions) known.insert({e.from, e.to});
    const std::set<char> robots = graph_.robots();
    const auto isKnown = [&](const Name& n) {
      return known.count(n) > 0 || graph_.landmarks.count(n) > 0 ||
             (n.letter == kLandmarkLetter && robots.count(n.letter) == 0);
    };
    const auto unusable = [&](const Numbered<RangeEdge>& r) {
      for (const Name& n : {r.item.a, r.item.b}) {
        if (isKnown(n)) continue;
        log_->add("range_unknown_vertex", graph_.where(r.line),
                  "a range names " + toString(n) + ", which is neither a pose nor a landmark of " +
                      "this file; not used");
        return true;
      }
      return false;
    };
    auto& ranges = graph_.ranges;
    ranges.erase(std::remove_if(ranges.begin(), ranges.end(), unusable), ranges.end());
  }

  std::string firstProblem() const {
    return log_->messages().empty() ? std::string("; it is empty")
                                    : "; first problem: " + log_->messages().front();
  }

  LineReader lines_;
  ProblemLog* log_;
  Graph graph_;
  std::set<Name> seen_vertices_;
  std::set<std::pair<Name, Name>> seen_motions_;
  std::set<std::tuple<TimeNs, Name, Name>> seen_ranges_;
};

}  // namespace

std::set<char> Graph::robots() const {
  std::set<char> letters;
  for (const auto& v : vertices) letters.insert(v.item.name.letter);
  for (const auto& e : motions) letters.insert({e.item.from.letter, e.item.to.letter});
  return letters;
}

Graph readGraph(const std::string& path, ProblemLog* log) { return GraphReader(path, log).read(); }

}  // namespace vir::pyfg
