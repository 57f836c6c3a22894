#pragma once
/// A piece of a recording in the EuRoC layout with faults put in: the images are links to the
/// original's, the tables are copies that a test edits before it calls write().
#include <cstdint>
#include <filesystem>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "vir_test_temp_folder.h"

namespace vir::test {

class DerivedRecording {
 public:
  struct Image {
    std::int64_t t = 0;  ///< [ns], as in data.csv
    std::string file;    ///< name in cam0/data
  };
  struct Row {
    std::int64_t t = 0;
    std::string text;  ///< the whole line
  };

  /// The first `seconds` after the first image of `source`.
  DerivedRecording(const std::filesystem::path& source, double seconds)
      : source_(source / "mav0"), root_(temp_ / "recording") {
    for (const Row& row : table("cam0/data.csv", INT64_MAX)) {
      if (images.empty()) end_ = row.t + static_cast<std::int64_t>(1e9 * seconds);
      if (row.t <= end_) images.push_back({row.t, row.text.substr(row.text.find(',') + 1)});
    }
    imu = table("imu0/data.csv", end_ + 20'000'000);
  }

  /// Nanoseconds of `seconds` after the first image.
  std::int64_t at(double seconds) const {
    return first_ + static_cast<std::int64_t>(1e9 * seconds);
  }
  bool between(std::int64_t t, double from_s, double to_s) const {
    return t >= at(from_s) && t < at(to_s);
  }

  /// A picture that is in no recording, under `name` in cam0/data.
  void addPicture(const std::string& name, const cv::Mat& picture) const {
    const std::filesystem::path file = root_ / "mav0/cam0/data" / name;
    std::filesystem::create_directories(file.parent_path());
    if (!cv::imwrite(file.string(), picture)) throw std::runtime_error("cannot write " + name);
  }
  cv::Mat picture(const Image& image) const {
    return cv::imread((source_ / "cam0/data" / image.file).string(), cv::IMREAD_GRAYSCALE);
  }

  /// Writes the tables as they now are and returns the folder to import.
  std::string write(bool last_imu_row_cut = false) const {
    namespace fs = std::filesystem;
    std::string text = "#timestamp [ns],filename\n";
    const fs::path folder = root_ / "mav0/cam0/data";
    fs::create_directories(folder);
    for (const Image& i : images) {
      text += std::to_string(i.t) + "," + i.file + "\n";
      if (!fs::exists(folder / i.file)) {
        fs::create_symlink(fs::absolute(source_ / "cam0/data" / i.file), folder / i.file);
      }
    }
    writeText(root_ / "mav0/cam0/data.csv", text);
    text = "#timestamp [ns],wx,wy,wz,ax,ay,az\n";
    for (const Row& row : imu) text += row.text + "\n";
    if (last_imu_row_cut) text.resize(text.size() - imu.back().text.size() / 2);
    writeText(root_ / "mav0/imu0/data.csv", text);
    for (const char* name : {"cam0/sensor.yaml", "imu0/sensor.yaml"}) {
      fs::copy_file(source_ / name, root_ / "mav0" / name, fs::copy_options::skip_existing);
    }
    fs::create_symlink(fs::absolute(source_ / "state_groundtruth_estimate0"),
                       root_ / "mav0/state_groundtruth_estimate0");
    return root_.string();
  }

  std::filesystem::path folder() const { return root_; }
  std::filesystem::path temp() const { return temp_.path(); }

  std::vector<Image> images;
  std::vector<Row> imu;

 private:
  /// Rows up to `last`, without the header and without line ends.
  std::vector<Row> table(const std::string& name, std::int64_t last) {
    std::istringstream in(readText(source_ / name));
    std::vector<Row> rows;
    for (std::string line; std::getline(in, line);) {
      if (!line.empty() && line.back() == '\r') line.pop_back();
      if (line.empty() || line.front() == '#') continue;
      const std::int64_t t = std::stoll(line);
      if (t > last) break;
      rows.push_back({t, line});
    }
    if (first_ == 0) first_ = rows.at(0).t;
    return rows;
  }

  TempFolder temp_;
  std::filesystem::path source_, root_;
  std::int64_t first_ = 0, end_ = 0;
};

}  // namespace vir::test
