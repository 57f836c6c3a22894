#pragma once
/// Internal: the corners of a map's keyframes in few bytes, by kind in columns that compress well.
/// docs/loops.md has the layout.
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "map_bytes.h"
#include "vir/camera/camera_model.h"
#include "vir/types/loop.h"

namespace vir::mission {

/// What differs between corners of one kind: bytes of it.
enum class PointColumn {
  x_high,
  x_low,
  y_high,
  y_low,
  ray,       ///< of rays that are not those of their pixel; see docs/loops.md
  distance,  ///< inverse, with its accuracy
  like,      ///< which corner of the keyframe before looks most alike
  descriptor,
  count
};
constexpr std::size_t kPointColumns = static_cast<std::size_t>(PointColumn::count);

/// Makes the columns, keyframe by keyframe. `camera` may be null: rays are then written in full.
class PointEncoder {
 public:
  explicit PointEncoder(const CameraCalibration& camera);
  void add(const std::vector<PlacePoint>& points);
  /// Each column with its length in front.
  void write(MapWriter* out) const;

 private:
  std::string& column(PointColumn c) { return columns_[static_cast<std::size_t>(c)]; }
  std::shared_ptr<const camera::CameraModel> camera_;
  double step_px_;
  std::array<std::string, kPointColumns> columns_;
  std::vector<PlacePoint> before_;
};

/// Reads them again in that order. Throws std::runtime_error where they end early or say what
/// cannot be.
class PointDecoder {
 public:
  PointDecoder(const CameraCalibration& camera, MapReader* in);
  /// The next keyframe's.
  std::vector<PlacePoint> next(std::size_t count);
  /// Throws unless all was read.
  void requireEnd() const;

 private:
  MapReader& column(PointColumn c) { return columns_[static_cast<std::size_t>(c)]; }
  Eigen::Vector3f readRay(const Eigen::Vector2f& px);
  std::shared_ptr<const camera::CameraModel> camera_;
  double step_px_;
  std::vector<MapReader> columns_;
  std::vector<PlacePoint> before_;
};

}  // namespace vir::mission
