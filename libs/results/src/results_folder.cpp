#include "vir/results/results_folder.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "vir/core/host_clock.h"

namespace vir::results {
namespace fs = std::filesystem;
namespace {

constexpr const char* kPart = ".part";

constexpr const char* kOurFiles[] = {"trajectory.tum",
                                     "calibration.yaml",
                                     "trajectory_covariance.csv",
                                     "trajectory_smoothed.tum",
                                     "trajectory_odom.tum",
                                     "loops.csv",
                                     "trajectory_survey.tum",
                                     "trajectory_smoothed_survey.tum",
                                     "anchors_survey.csv",
                                     "frames.csv",
                                     "anchors.csv",
                                     "ranges.csv",
                                     "landmarks.ply",
                                     "summary.json",
                                     "used.ini",
                                     "run.log",
                                     "report.html",
                                     "map.svg",
                                     "ranges.svg",
                                     "transforms.json",
                                     "transforms_over_time.csv",
                                     "rendezvous.svg",
                                     "scene.3Dscene"};

/// Two runs within one second must not share a folder.
fs::path freshFolder(const fs::path& base) {
  fs::path folder = base;
  for (int i = 2; fs::exists(folder); ++i) folder = base.string() + "-" + std::to_string(i);
  return folder;
}

void pointLatestTo(const fs::path& folder) {
  std::error_code ignored;  // a convenience: a file system without links must not stop the run
  const fs::path link = folder.parent_path() / "latest";
  if (fs::is_symlink(fs::symlink_status(link, ignored))) fs::remove(link, ignored);
  fs::create_directory_symlink(folder.filename(), link, ignored);
}

/// Other programs write a summary.json as well.
bool isOurSummary(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string begin(1 << 16, '\0');
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(in.gcount()));
  return begin.find("\"verdict\"") != begin.npos;
}

}  // namespace

OutputFile::OutputFile(const std::string& path, Named named) : path_(path) {
  std::error_code ignored;
  if (fs::is_symlink(fs::symlink_status(path, ignored)) && fs::is_regular_file(path, ignored)) {
    path_ = fs::canonical(path, ignored).string();  // the link stays one
  }
  const bool replaceable = !fs::exists(path_, ignored) || fs::is_regular_file(path_, ignored);
  written_to_ = named == Named::when_complete && replaceable ? path_ + kPart : path_;
  errno = 0;
  out_.open(written_to_, std::ios::binary | std::ios::trunc);
  if (!out_) {
    throw std::runtime_error("cannot write " + path + ": " +
                             (errno != 0 ? std::strerror(errno) : "unknown reason"));
  }
}

void OutputFile::close() {
  errno = 0;
  out_.close();
  if (out_.fail()) {
    throw std::runtime_error("cannot finish writing " + path_ + ": " +
                             (errno != 0 ? std::strerror(errno) : "is the disk full?"));
  }
  if (written_to_ == path_) return;
  std::error_code error;
  fs::rename(written_to_, path_, error);
  if (error) {
    throw std::runtime_error("cannot rename " + written_to_ + " to " + path_ + ": " +
                             error.message());
  }
}

void writeTextFile(const std::string& path, const std::string& text) {
  OutputFile file(path);
  file.stream() << text;
  file.close();
}

std::string foreignFileIn(const std::string& folder) {
  std::error_code ignored;
  for (const char* name : {"used.ini", "run.log"}) {
    if (fs::exists(fs::path(folder) / name, ignored)) return {};
  }
  if (isOurSummary(fs::path(folder) / "summary.json")) return {};
  for (const char* name : kOurFiles) {
    const fs::path file = fs::path(folder) / name;
    if (fs::exists(file, ignored)) return file.string();
  }
  // What `run` imports goes there.
  const fs::path imported = fs::path(folder) / "recording.rawlog";
  return fs::exists(imported, ignored) ? imported.string() : std::string();
}

ResultsFolder::ResultsFolder(const std::string& out) {
  const fs::path folder =
      out.empty() ? freshFolder(fs::path("results") / localDateTime()) : fs::path(out);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder)) {
    throw std::runtime_error("cannot create the results folder " + folder.string() + ": " +
                             (error ? error.message() : "it is a file"));
  }
  lock_ = std::make_shared<const OutputLock>(folder.string());
  if (out.empty()) pointLatestTo(folder);
  path_ = folder.string();
  for (const std::string name : kOurFiles) {
    fs::remove(folder / name, error);
    fs::remove(folder / (name + kPart), error);
  }
}

}  // namespace vir::results
