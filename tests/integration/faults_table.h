#pragma once
/// The table of docs/faults.md: what has to become of each command in each fault.
#include <csignal>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "vir_test_paths.h"
#include "vir_test_temp_folder.h"

namespace vir {

struct FaultRow {
  std::string fault;
  std::map<std::string, std::string> cells;  ///< by the name of the command
};

inline std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line.substr(1));  // after the first `|`
  for (std::string cell; std::getline(in, cell, '|');) {
    const std::size_t from = cell.find_first_not_of(' '), to = cell.find_last_not_of(' ');
    cells.push_back(from == std::string::npos ? "" : cell.substr(from, to - from + 1));
  }
  return cells;
}

/// In the order of the file.
inline std::vector<FaultRow> faultTable() {
  std::istringstream in(test::readText(test::sourceDir() + "/docs/faults.md"));
  std::vector<std::string> head;
  std::vector<FaultRow> rows;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] != '|' || line.rfind("|---", 0) == 0) continue;
    const std::vector<std::string> cells = cellsOf(line);
    if (head.empty()) {
      head = cells;
      continue;
    }
    if (cells.size() != head.size()) throw std::runtime_error("docs/faults.md: " + line);
    FaultRow row{cells[0], {}};
    for (std::size_t i = 1; i < cells.size(); ++i) {
      std::istringstream names(head[i]);  // `run`, `rendezvous`
      for (std::string name; std::getline(names, name, '`') && std::getline(names, name, '`');) {
        row.cells[name] = cells[i];
      }
    }
    rows.push_back(row);
  }
  return rows;
}

/// Exit code (or -signal) that a cell begins with.
inline int exitCodeOf(const std::string& cell) {
  const std::string word = cell.substr(0, cell.find_first_of(",; "));
  if (word == "killed") return -SIGKILL;
  std::size_t used = 0;
  const int code = std::stoi(word, &used);
  if (used != word.size()) throw std::runtime_error("docs/faults.md: no exit code: " + cell);
  return code;
}

}  // namespace vir
