#pragma once
/// What `vir-slam export` writes: one class per format, fed with the observations of a rawlog in
/// time order.
#include <mrpt/obs/CObservation.h>

#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "recordings/companion.h"
#include "vir/results/results_folder.h"

namespace vir::app {

class Exporter {
 public:
  virtual ~Exporter() = default;
  enum class Added { written, no_place, unusable };
  /// `no_place`: the format has none for it. `unusable`: an image that is missing, was refused or
  /// cannot be decoded. Throws std::runtime_error if it cannot be written.
  virtual Added add(mrpt::obs::CObservation& observation) = 0;
  /// Completes the files, which have their names only then; throws std::runtime_error.
  virtual void finish() = 0;
};

/// `<label>.tum` per label of poses.
std::unique_ptr<Exporter> makeTumExporter(const std::string& folder, bool force);

/// `<label>.csv` per label, nanoseconds in the first column; images as a list only.
/// `anchors`: what those of a name were called.
std::unique_ptr<Exporter> makeCsvExporter(const std::string& folder, bool force,
                                          AnchorTexts anchors);

/// EuRoC's folder `mav0`, which `import euroc` reads back. `companion`: the ini that import left
/// beside the rawlog (noise densities), may be empty.
std::unique_ptr<Exporter> makeEurocExporter(const std::string& folder, const std::string& companion,
                                            AnchorTexts anchors);

/// One MCAP file with standard messages of ROS 2, which `import rosbag2` reads back.
std::unique_ptr<Exporter> makeMcapExporter(const std::string& file, AnchorTexts anchors);
/// Trajectories, anchors and landmarks of a run's folder, likewise.
void exportRunToMcap(const std::string& run_folder, const std::string& file);

/// Text files by name, created when first written to; `NAME.part` until close().
class FileSet {
 public:
  /// A file that is there already and begins otherwise than ours is left alone but with `force`:
  /// at() throws UsageError.
  explicit FileSet(std::string folder, bool force = true)
      : folder_(std::move(folder)), force_(force) {}
  ~FileSet();
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;
  /// `header` is written when the file is new.
  results::OutputFile& at(const std::string& name, const std::string& header);
  void close();

 private:
  std::string folder_;
  bool force_;
  std::map<std::string, std::unique_ptr<results::OutputFile>> files_;
};

/// A label as a file name: what is no letter, digit, `-` or `.` becomes `_`, as does a `.` at the
/// begin.
std::string fileName(const std::string& label);

/// A name of a file as a cell of a table: no control characters, quoted where it has a comma or a
/// quote, and nothing that a spreadsheet takes for a formula (`=1+1` becomes `./=1+1`, the same
/// file).
std::string cell(std::string name);

/// Told by the first bytes of a file: what goes out as it is must not be any other file.
inline bool isPng(std::string_view begin) { return begin.rfind("\x89PNG\r\n\x1a\n", 0) == 0; }

/// A number that reads back as the same double, or float.
std::string exact(double v);
std::string exact(float v);

}  // namespace vir::app
