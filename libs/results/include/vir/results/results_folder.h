#pragma once
#include <fstream>
#include <memory>
#include <string>

#include "vir/results/output_lock.h"

namespace vir::results {

/// A text file that is written as the run goes. Nothing is lost in silence: close() throws
/// std::runtime_error naming the file if the disk is full.
class OutputFile {
 public:
  /// `when_complete`: NAME.part until close(), so that half a file is never taken for a whole one.
  /// `at_once`: for logs, which are read while they grow. Devices and pipes have no `.part`.
  enum class Named { when_complete, at_once };
  /// Throws std::runtime_error naming file and reason if it cannot be created.
  explicit OutputFile(const std::string& path, Named named = Named::when_complete);
  std::ostream& stream() { return out_; }
  void line(const std::string& text) { out_ << text << '\n'; }
  void close();

 private:
  std::string path_;
  std::string written_to_;  // path_, or its .part
  std::ofstream out_;
};

/// Writes a whole file at once; throws like OutputFile.
void writeTextFile(const std::string& path, const std::string& text);

/// A file in `folder` that has the name of one of ours although no run has left its settings, log
/// or summary there: to be lost if the folder became that of a run. Empty: there is none.
std::string foreignFileIn(const std::string& folder);

/// The folder of one run.
class ResultsFolder {
 public:
  /// `out`, or where it is empty `results/<date-time>` with `results/latest` pointing to it.
  /// Creates it; files of an earlier run in it that this program writes are removed, so that none
  /// can be taken for new. Throws std::runtime_error naming the folder and the reason.
  /// Throws as well if another process has the folder, which stays locked while this lives.
  explicit ResultsFolder(const std::string& out);
  const std::string& path() const { return path_; }
  std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
  std::shared_ptr<const OutputLock> lock_;
};

}  // namespace vir::results
