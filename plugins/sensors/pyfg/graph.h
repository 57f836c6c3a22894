#pragma once
/// A PyFG file as a whole, checked. It is held in memory: its lines come grouped by kind, not by
/// time (about 0.5 kB per line).
#include <map>
#include <set>
#include <string>
#include <vector>

#include "graph_line.h"
#include "problem_log.h"

namespace vir::pyfg {

/// What a line said, and where it stood.
template <typename Item>
struct Numbered {
  Item item;
  long line = 0;  ///< 1-based
};

struct Graph {
  std::string path;
  std::vector<Numbered<Vertex>> vertices;  ///< in the file's order, as everything here
  std::vector<Numbered<MotionEdge>> motions;
  std::vector<Numbered<RangeEdge>> ranges;
  std::map<Name, Landmark> landmarks;

  /// Letters that have poses, in alphabetical order.
  std::set<char> robots() const;
  /// "path:line" for messages.
  std::string where(long line) const { return path + ":" + std::to_string(line); }
};

/// Reads the file. What cannot be used is left out, counted and told with file and line in the
/// log: lines that parseLine() refuses, a last line without line break, things said twice
/// (the first counts), ranges that name a pose nothing else in the file knows. Throws InputError if
/// the file cannot be read or holds no line that can be used.
Graph readGraph(const std::string& path, ProblemLog* log);

}  // namespace vir::pyfg
