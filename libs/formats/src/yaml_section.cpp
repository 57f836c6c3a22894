#include "vir/formats/yaml_section.h"

#include <yaml-cpp/yaml.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "vir/core/text_file.h"
#include "vir/core/text_stream.h"
#include "vir/formats/calibration_file.h"

namespace vir::formats {
namespace fs = std::filesystem;
namespace {

/// A rotation written with 3 decimals is still accepted (and made exact); a scale or a shear not.
constexpr double kRotationTolerance = 5e-3;
/// Calibrations are small; a larger file is something else.
constexpr std::uintmax_t kMaxBytes = 4u << 20;
/// Numbers of one key. Lists may repeat each other by reference, so the file's size is no bound.
constexpr std::size_t kMaxNumbers = 4096;
/// Brackets and indentation deeper than this are no calibration, and the parser recurses.
constexpr int kMaxDepth = 64;

struct Document {
  std::string text;
  int tab_line = 0;  ///< the first that is indented with a tab; 0: none
};

/// The document without the `%YAML:1.0` line of OpenCV's dialect, which is not YAML. A tab counts
/// as one blank: YAML forbids them as indentation, but files edited by hand have them, and where
/// all of a block is indented alike the meaning is clear.
Document documentOf(const std::string& path) {
  std::error_code ec;
  if (!fs::is_regular_file(path, ec)) {
    throw CalibrationError(path + ": no such file; the calibration is needed");
  }
  if (fs::file_size(path, ec) > kMaxBytes) {
    throw CalibrationError(path + ": is too large for a calibration");
  }
  const std::string why = whyNoText(path);
  if (!why.empty()) throw CalibrationError(path + ": " + why);
  TextStream file(path);
  if (!file) throw CalibrationError(path + ": cannot be read (permissions?)");
  Document out;
  std::string line;
  int depth = 0, deepest = 0;
  for (int number = 1; readLine(file, &line); ++number) {
    if (number == 1 && line.compare(0, 3, "\xEF\xBB\xBF") == 0) line.erase(0, 3);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.compare(0, 5, "%YAML") == 0) line.clear();  // lines keep their numbers
    const std::size_t content = line.find_first_not_of(" \t");
    if (out.tab_line == 0 && content != std::string::npos && line.find('\t') < content) {
      out.tab_line = number;
    }
    std::replace(line.begin(), line.end(), '\t', ' ');
    for (const char c : line) {
      if (c == '[' || c == '{') deepest = std::max(deepest, ++depth);
      if (c == ']' || c == '}') --depth;
    }
    const std::size_t indent = line.find_first_not_of(" -?:");
    if (indent != std::string::npos && indent > 4 * kMaxDepth) deepest = kMaxDepth + 1;
    out.text += line + '\n';
  }
  if (deepest > kMaxDepth) throw CalibrationError(path + ": is not readable YAML: nested too deep");
  return out;
}

/// Where a value stands that is no number, and why where that is seen.
std::string lineAndCause(const YAML::Node& node) {
  std::string out = " (line " + std::to_string(node.Mark().line + 1);
  if (node.IsScalar()) {
    const std::string text = node.Scalar().substr(0, 40);
    out += ": `" + text + "`";
    if (text.find_first_not_of("0123456789+-,eE ") == std::string::npos &&
        text.find(',') != std::string::npos) {
      out += ", a decimal comma? write a point";
    }
  }
  return out + ")";
}

void flatten(const YamlSection& section, const std::string& key, const YAML::Node& node,
             std::vector<double>* out) {
  if (out->size() > kMaxNumbers) section.fail("`" + section.named(key) + "` has too many numbers");
  if (node.IsSequence()) {
    for (const auto& child : node) flatten(section, key, child, out);
    return;
  }
  double v = 0;
  try {
    v = node.as<double>();
  } catch (const YAML::Exception&) {
    section.fail(section.named(key) + " is not a number" + lineAndCause(node));
  }
  if (!std::isfinite(v)) section.fail(section.named(key) + " is not finite");
  out->push_back(v);
}

Mat3 nearestRotation(const Mat3& R) {
  const Eigen::JacobiSVD<Mat3> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

bool isRotation(const Mat3& R) {
  return (R * R.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() < kRotationTolerance &&
         R.determinant() > 0;
}

}  // namespace

YamlSection::YamlSection(std::string path, std::string prefix, const YAML::Node& node)
    : path_(std::move(path)),
      prefix_(std::move(prefix)),
      node_(std::make_shared<const YAML::Node>(node)) {}

YamlSection YamlSection::load(const std::string& path) {
  const Document document = documentOf(path);
  try {
    const YAML::Node node = YAML::Load(document.text);
    if (!node.IsMap()) throw CalibrationError(path + ": is empty or holds no `key: value` lines");
    return YamlSection(path, "", node);
  } catch (const YAML::Exception& e) {
    const std::string tabs =
        document.tab_line == 0
            ? ""
            : "; line " + std::to_string(document.tab_line) +
                  " is indented with a tab, others may be with blanks: write blanks everywhere";
    throw CalibrationError(path + ": is not readable YAML: " + e.what() + tabs);
  }
}

void YamlSection::fail(const std::string& text) const {
  throw CalibrationError(path_ + ": " + text);
}

YAML::Node YamlSection::at(const std::string& key) const {
  // Of a constant node: a key that is not there must not be made.
  const YAML::Node found = (*node_)[key];
  return found.IsDefined() ? found : YAML::Node(YAML::NodeType::Null);
}

bool YamlSection::has(const std::string& key) const { return !at(key).IsNull(); }

std::string YamlSection::firstOf(const std::vector<std::string>& keys) const {
  for (const std::string& key : keys) {
    if (has(key)) return key;
  }
  return {};
}

std::string YamlSection::lineOf(const std::string& key) const {
  const YAML::Node node = at(key);
  const YAML::Mark mark = node.Mark();
  if (node.IsNull() || mark.is_null()) return "";
  return " (line " + std::to_string(mark.line + 1) + ")";
}

std::vector<std::string> YamlSection::keys() const {
  std::vector<std::string> out;
  for (const auto& item : *node_) {
    if (item.first.IsScalar()) out.push_back(item.first.Scalar());
  }
  return out;
}

bool YamlSection::isMap(const std::string& key) const { return at(key).IsMap(); }

YamlSection YamlSection::child(const std::string& key) const {
  const YAML::Node node = at(key);
  if (!node.IsMap()) fail("`" + named(key) + "` is not a block of `key: value` lines");
  return YamlSection(path_, prefix_ + key + ".", node);
}

double YamlSection::number(const std::string& key) const {
  const YAML::Node node = at(key);
  if (node.IsNull()) fail("`" + named(key) + "` is missing");
  if (!node.IsScalar()) fail(named(key) + " is not a number");
  std::vector<double> out;
  flatten(*this, key, node, &out);
  return out.front();
}

std::optional<double> YamlSection::optionalNumber(const std::string& key) const {
  if (!has(key)) return std::nullopt;
  return number(key);
}

std::vector<double> YamlSection::numbers(const std::string& key) const {
  const YAML::Node whole = at(key);
  if (whole.IsNull()) fail("`" + named(key) + "` is missing");
  const YAML::Node node = whole.IsMap() ? whole["data"] : whole;
  if (!node.IsDefined() || !node.IsSequence()) {
    fail("`" + named(key) + "` is not a list of numbers");
  }
  std::vector<double> out;
  flatten(*this, key, node, &out);
  return out;
}

std::string YamlSection::text(const std::string& key) const {
  const YAML::Node node = at(key);
  return node.IsScalar() ? node.Scalar() : std::string();
}

Pose YamlSection::pose(const std::string& key) const {
  const std::vector<double> v = numbers(key);
  if (v.size() != 16 && v.size() != 12) {
    fail("`" + named(key) + "` has " + std::to_string(v.size()) + " numbers, not 16");
  }
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T;
  T.setIdentity();
  std::copy(v.begin(), v.end(), T.data());
  const Mat3 R = T.topLeftCorner<3, 3>();
  const Eigen::RowVector4d last(0, 0, 0, 1);
  if (!isRotation(R) || (T.row(3) - last).cwiseAbs().maxCoeff() > 1e-6) {
    fail(
        "`" + named(key) +
        "` is not a rigid transform (the upper left 3x3 must be a rotation, the last row 0 0 0 1)");
  }
  // The nearest rotation: digits cut off in the file must not bend what is computed from it.
  return {Quat(nearestRotation(R)).normalized(), T.topRightCorner<3, 1>()};
}

Mat3 YamlSection::rotation(const std::string& key) const {
  const std::vector<double> v = numbers(key);
  if (v.size() != 9) {
    fail("`" + named(key) + "` has " + std::to_string(v.size()) + " numbers, not 9");
  }
  const Mat3 R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(v.data());
  if (!isRotation(R)) fail("`" + named(key) + "` is not a rotation");
  return nearestRotation(R);
}

}  // namespace vir::formats
