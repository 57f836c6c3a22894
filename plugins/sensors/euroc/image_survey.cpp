#include "image_survey.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>

#include "image_head.h"

namespace vir::euroc {
namespace fs = std::filesystem;
namespace {

constexpr double kTail = 0.001;        // of the pixels on either side
constexpr double kEnoughShare = 0.25;  // of the bits' range that contrast must fill
constexpr double kRoom = 0.1;          // of the contrast, on either side

// Of 8 bits: nothing is brighter, and there is more than noise between darkest and brightest.
constexpr double kDarkest8 = 31, kLeastContrast8 = 6;

template <typename Pixel>
void addHistogram(const cv::Mat& image, std::vector<std::uint64_t>* histogram) {
  const int values = image.cols * image.channels();
  for (int y = 0; y < image.rows; ++y) {
    const auto* row = image.ptr<Pixel>(y);
    for (int x = 0; x < values; ++x) ++(*histogram)[row[x]];
  }
}

/// Empty if it is none.
cv::Mat decoded(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  if (bytes.empty() || !pixelsFit(data, bytes.size())) return {};
  try {
    return cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    return {};
  }
}

/// The grey value that a share of `share` lies below.
double percentile(const std::vector<std::uint64_t>& histogram, double share) {
  std::uint64_t total = 0;
  for (const std::uint64_t n : histogram) total += n;
  const double wanted = share * static_cast<double>(total);
  double below = 0;
  for (std::size_t v = 0; v < histogram.size(); ++v) {
    below += static_cast<double>(histogram[v]);
    if (below > wanted) return static_cast<double>(v);
  }
  return static_cast<double>(histogram.size() - 1);
}

}  // namespace

ImageSurvey surveyImages(const std::vector<std::string>& files) {
  ImageSurvey survey;
  std::vector<std::uint64_t> histogram;
  for (const std::string& file : files) {
    const cv::Mat image = decoded(file);
    if (image.empty()) continue;
    if (survey.width == 0) {
      survey.width = image.cols;
      survey.height = image.rows;
      survey.sixteen_bit = image.depth() == CV_16U;
      if (!survey.sixteen_bit && image.depth() != CV_8U) return survey;
      histogram.resize(survey.sixteen_bit ? 65536 : 256);
    }
    if (survey.sixteen_bit && image.depth() == CV_16U) {
      addHistogram<std::uint16_t>(image, &histogram);
    } else if (!survey.sixteen_bit && image.depth() == CV_8U) {
      addHistogram<std::uint8_t>(image, &histogram);
      // Bright enough already, as nearly every recording is.
      if (percentile(histogram, 1 - kTail) > kDarkest8) return survey;
    }
  }
  if (survey.width == 0) return survey;
  survey.low = percentile(histogram, kTail);
  survey.high = percentile(histogram, 1 - kTail);
  return survey;
}

namespace {

Stretch stretchOf8(const ImageSurvey& survey) {
  Stretch out;
  const double contrast = survey.high - survey.low;
  out.eight_bit = survey.high <= kDarkest8 && contrast >= kLeastContrast8;
  if (!out.eight_bit) return out;
  out.black = std::max(0.0, std::floor(survey.low - kRoom * contrast));
  out.white = std::ceil(survey.high + kRoom * contrast);
  char text[120];
  std::snprintf(text, sizeof text,
                "images that hold %.0f to %.0f of 255 were stretched, the same all through: they "
                "are very dark",
                survey.low, survey.high);
  out.said = text;
  return out;
}

}  // namespace

Stretch stretchOf(const ImageSurvey& survey) {
  Stretch out;
  if (!survey.sixteen_bit) return stretchOf8(survey);
  const double contrast = survey.high - survey.low;
  for (const int bits : {10, 12, 14, 16}) {
    const double top = std::ldexp(1.0, bits) - 1;
    if (survey.high > top) continue;
    if (contrast < kEnoughShare * (top + 1)) break;
    out.white = top;
    if (bits < 16) out.said = "images of " + std::to_string(bits) + " bits";
    return out;
  }
  const double room = std::max(kRoom * contrast, 8.0);
  out.black = std::max(0.0, std::floor(survey.low - room));
  out.white = std::min(65535.0, std::ceil(survey.high + room));
  char text[96];
  std::snprintf(text, sizeof text, "images that hold %.0f to %.0f of 65535 stretched to 8 bits",
                out.black, out.white);
  out.said = text;
  return out;
}

std::string imageFile(const std::string& camera_dir, const std::string& listed) {
  const std::string below_data = camera_dir + "/data/" + listed;
  std::error_code ec;
  if (fs::is_regular_file(below_data, ec)) return below_data;
  const std::string last = fs::path(listed).filename().string();
  for (const std::string& file :
       {camera_dir + "/" + listed, camera_dir + "/data/" + last, camera_dir + "/" + last}) {
    if (fs::is_regular_file(file, ec)) return file;
    for (const char* extension : {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".pgm"}) {
      if (fs::is_regular_file(file + extension, ec)) return file + extension;
    }
  }
  return below_data;
}

}  // namespace vir::euroc
