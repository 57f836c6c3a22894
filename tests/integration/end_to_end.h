#pragma once
/// From a folder with a recording to a trajectory, with the program as a user calls it.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "vir/evaluation/evaluate.h"
#include "vir_test_data.h"
#include "vir_test_paths.h"
#include "vir_test_shell.h"
#include "vir_test_temp_folder.h"

namespace vir::test {

inline const char* const kMh01 = "euroc_MH01_clip30s";
inline const char* const kRendered = "rendered_V102_32s";

struct RunResult {
  Outcome outcome;
  std::string folder;
  nlohmann::json summary;  ///< null when there is none
  Trajectory trajectory;   ///< trajectory.tum

  long counter(const std::string& name) const {
    if (!summary.is_object() || !summary["counters"].contains(name)) return -1;
    return summary["counters"][name];
  }
  /// Whether a warning of the summary contains `part`.
  bool warns(const std::string& part) const {
    if (!summary.is_object()) return false;
    for (const auto& w : summary["warnings"]) {
      if (contains(w.get<std::string>(), part)) return true;
    }
    return false;
  }
};

inline Outcome importEuroc(const std::string& source, const std::string& rawlog,
                           const std::string& more = "") {
  return virSlam("import euroc " + quoted(source) + " --out " + quoted(rawlog) + " " + more);
}

inline RunResult runVir(const std::string& rawlog, const std::string& folder,
                        const std::string& more = "") {
  RunResult r;
  r.folder = folder;
  r.outcome = virSlam("run " + quoted(test::sourceDir() + "/ini/euroc.ini") + " --rawlog " +
                      quoted(rawlog) + " --out " + quoted(folder) + " " + more);
  namespace fs = std::filesystem;
  if (fs::exists(folder + "/summary.json")) {
    r.summary = nlohmann::json::parse(readText(folder + "/summary.json"));
  }
  if (fs::exists(folder + "/trajectory.tum")) {
    std::ifstream in(folder + "/trajectory.tum");
    evaluation::ReadReport report;
    r.trajectory = evaluation::readTum(in, &report);
  }
  return r;
}

/// Stamps of cam0/data.csv, ascending.
inline std::vector<TimeNs> imageStamps(const std::filesystem::path& recording) {
  std::ifstream in(recording / "mav0/cam0/data.csv");
  return evaluation::readStamps(in);
}

/// The ground truth of either layout of the test data.
inline Trajectory groundTruth(const std::filesystem::path& recording) {
  const std::filesystem::path folder = recording / "mav0/state_groundtruth_estimate0";
  const bool csv = std::filesystem::exists(folder / "data.csv");
  std::ifstream in(folder / (csv ? "data.csv" : "gt_tum.txt"));
  evaluation::ReadReport report;
  return evaluation::readTrajectory(in, &report);
}

/// "nan" or "inf" as a word of a file below `folder`: "file: line", or empty. The log may use
/// words.
inline std::string notFinite(const std::string& folder) {
  for (const auto& item : std::filesystem::recursive_directory_iterator(folder)) {
    // A scene is compressed: three letters in it mean nothing.
    const auto kind = item.path().extension();
    if (!item.is_regular_file() || kind == ".log" || kind == ".3Dscene") continue;
    std::istringstream in(readText(item.path()));
    for (std::string line; std::getline(in, line);) {
      std::string words = line;
      for (char& c : words) {
        c = std::isalnum(static_cast<unsigned char>(c)) ? static_cast<char>(std::tolower(c)) : ' ';
      }
      std::istringstream split(words);
      for (std::string word; split >> word;) {
        if (word == "nan" || word == "inf") return item.path().filename().string() + ": " + line;
      }
    }
  }
  return {};
}

/// Position errors against the truth after a position and yaw alignment on the poses before
/// `split`; that is what drifted away since.
struct SplitError {
  double before = 0;             ///< RMS [m]
  evaluation::Statistics after;  ///< [m]
};

inline SplitError splitError(const Trajectory& truth, const Trajectory& estimate, TimeNs split) {
  const evaluation::Association all = evaluation::associate(truth, estimate, {});
  std::vector<evaluation::PosePair> fitted;
  for (const evaluation::PosePair& p : all.pairs) {
    if (p.t < split) fitted.push_back(p);
  }
  const evaluation::AlignmentResult a = evaluation::align(fitted, evaluation::Alignment::posyaw);
  std::vector<double> before, after;
  for (const evaluation::PosePair& p : all.pairs) {
    (p.t < split ? before : after).push_back((a.apply(p.estimate).p - p.reference.p).norm());
  }
  return {evaluation::statisticsOf(before).rmse, evaluation::statisticsOf(after)};
}

}  // namespace vir::test
