#pragma once
/// Small videos, written for a test.
#include <cstdint>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "vir_test_temp_folder.h"

namespace vir::test {

inline int greyOfFrame(int i) { return 20 + 6 * i; }

/// Frames that are evenly grey (greyOfFrame), with a bright left half where `half`.
inline void writeVideo(const std::filesystem::path& path, int frames, double rate_hz,
                       const char* codec = "MJPG", cv::Size size = {64, 48}, bool half = false) {
  std::filesystem::create_directories(path.parent_path());
  cv::VideoWriter writer(path.string(),
                         cv::VideoWriter::fourcc(codec[0], codec[1], codec[2], codec[3]), rate_hz,
                         size);
  if (!writer.isOpened()) throw std::runtime_error("no video can be written: " + path.string());
  for (int i = 0; i < frames; ++i) {
    cv::Mat frame(size, CV_8UC3, cv::Scalar::all(greyOfFrame(i)));
    if (half) frame.colRange(0, size.width / 2).setTo(cv::Scalar::all(250));
    writer.write(frame);
  }
}

/// Boxes of an mp4, for what OpenCV cannot write.
class Mp4Edit {
 public:
  explicit Mp4Edit(std::filesystem::path path) : path_(std::move(path)), bytes_(readText(path_)) {}

  /// Time from each frame to the next in units of the track, one per frame.
  void setFrameLengths(const std::vector<std::uint32_t>& lengths) {
    const std::vector<std::size_t> way = wayTo({"moov", "trak", "mdia", "minf", "stbl", "stts"});
    if (way.front() < bytes_.find("mdat")) throw std::runtime_error("the index lies in front");
    std::string box = number(0) + number(static_cast<std::uint32_t>(lengths.size()));
    for (const std::uint32_t length : lengths) box += number(1) + number(length);
    const std::uint32_t before = at(way.back()), now = static_cast<std::uint32_t>(box.size() + 8);
    bytes_.replace(way.back() + 8, before - 8, box);
    for (const std::size_t b : way) put(b, at(b) + now - before);
  }
  /// As phones say that they were held upright.
  void turnBy90() {
    const std::size_t matrix = wayTo({"moov", "trak", "tkhd"}).back() + 48;
    const std::uint32_t values[9] = {0, 0x10000, 0, 0xFFFF0000, 0, 0, 48u << 16, 0, 0x40000000};
    for (std::size_t i = 0; i < 9; ++i) put(matrix + 4 * i, values[i]);
  }
  std::uint32_t unitsPerSecond() const {
    return at(wayTo({"moov", "trak", "mdia", "mdhd"}).back() + 20);
  }
  void save() const { writeText(path_, bytes_); }

 private:
  static std::string number(std::uint32_t v) {
    std::string out;
    for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(v >> shift);
    return out;
  }
  std::uint32_t at(std::size_t i) const {
    std::uint32_t v = 0;
    for (std::size_t k = 0; k < 4; ++k) v = v << 8 | static_cast<unsigned char>(bytes_.at(i + k));
    return v;
  }
  void put(std::size_t i, std::uint32_t v) { bytes_.replace(i, 4, number(v)); }
  /// Where each of these boxes begins.
  std::vector<std::size_t> wayTo(const std::vector<std::string>& names) const {
    std::vector<std::size_t> way;
    std::size_t from = 0, end = bytes_.size();
    for (const std::string& name : names) {
      while (from + 8 <= end && bytes_.compare(from + 4, 4, name) != 0) from += at(from);
      if (from + 8 > end) throw std::runtime_error("no box " + name);
      way.push_back(from);
      end = from + at(from);
      from += 8;
    }
    return way;
  }

  std::filesystem::path path_;
  std::string bytes_;
};

}  // namespace vir::test
