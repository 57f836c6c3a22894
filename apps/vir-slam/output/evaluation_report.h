#pragma once
/// What `vir-slam evaluate` says: a table for the eye, JSON for programs.
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "vir/evaluation/evaluate.h"

namespace vir::app {

/// Images of the recording and how many of them have a pose.
struct ImageCoverage {
  long images = 0;
  long covered = 0;
  double first_pose_after_s = 0;  ///< from the first image to the first pose
};
/// An image is covered by a pose within a millisecond of it: writers round stamps differently.
ImageCoverage imageCoverage(const std::vector<TimeNs>& images, const Trajectory& estimate);

/// One estimate: either a result, or the reason why there is none.
struct Evaluated {
  std::string file;
  std::string name;  ///< short, for heads of columns
  evaluation::ReadReport read;
  std::optional<ImageCoverage> images;
  std::optional<evaluation::EvaluationResult> result;
  std::vector<std::string> hints;  ///< likely mistakes in how the files are written
  std::string error;
};

/// On the terminal: what was left out and why, and what seems to be wrong with the files.
void sayNotes(const Evaluated& estimate);

/// Rows are metrics with units, columns are estimates. `title` goes on top.
std::string evaluationTable(const std::string& title, const std::vector<Evaluated>& estimates);

nlohmann::json evaluationJson(const std::string& reference_file,
                              const evaluation::EvaluationOptions& options,
                              const std::vector<Evaluated>& estimates);

/// A picture of all that have a result, see writePicture; none of them: said on stderr, no picture.
void writeComparison(const std::string& path, const Trajectory& reference,
                     const std::vector<Evaluated>& estimates, const std::string& subtitle);

/// Short distinct names: the file name, or as much of the path as tells them apart.
std::vector<std::string> shortNames(const std::vector<std::string>& files);

}  // namespace vir::app
