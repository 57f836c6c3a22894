#pragma once
/// A YAML file, and a map in it, with errors that name file and key.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "vir/geometry/pose.h"

namespace YAML {
class Node;
}

namespace vir::formats {

/// A map of the file. Every reading throws CalibrationError.
class YamlSection {
 public:
  /// The whole file. OpenCV's `%YAML:1.0`, its tags, tabs and a byte-order mark are taken as meant.
  static YamlSection load(const std::string& path);

  bool has(const std::string& key) const;
  /// The first of `keys` that is there, or empty.
  std::string firstOf(const std::vector<std::string>& keys) const;
  std::vector<std::string> keys() const;
  bool isMap(const std::string& key) const;
  /// A map in this one; `key` is then part of what errors name.
  YamlSection child(const std::string& key) const;

  double number(const std::string& key) const;
  std::optional<double> optionalNumber(const std::string& key) const;
  /// A list, nested or flat, or a matrix with a list `data`.
  std::vector<double> numbers(const std::string& key) const;
  /// Empty if it is not there or no text.
  std::string text(const std::string& key) const;
  /// A 4x4 or 3x4 matrix that is a rigid transform; the nearest rotation where digits are missing.
  Pose pose(const std::string& key) const;
  /// The nearest rotation to a 3x3 matrix.
  Mat3 rotation(const std::string& key) const;

  [[noreturn]] void fail(const std::string& text) const;
  /// "cam0.T_cam_imu" of "T_cam_imu".
  std::string named(const std::string& key) const { return prefix_ + key; }
  /// " (line 7)" of the file, where the value of `key` begins; empty where it is not there.
  std::string lineOf(const std::string& key) const;
  const std::string& path() const { return path_; }

 private:
  YamlSection(std::string path, std::string prefix, const YAML::Node& node);
  YAML::Node at(const std::string& key) const;

  std::string path_, prefix_;
  std::shared_ptr<const YAML::Node> node_;
};

}  // namespace vir::formats
