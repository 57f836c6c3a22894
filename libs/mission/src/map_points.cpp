#include "map_points.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "vir/places/hamming.h"

namespace vir::mission {
namespace {

using Steps = std::array<std::int32_t, 3>;

/// Pixels are kept in steps of this, of larger images in as many as two bytes can tell.
constexpr double kStep_px = 1.0 / 16;
constexpr double kMostSteps = 65535;
/// Rays in steps of this; where the pixel's own is as near as so many it is taken.
constexpr double kRaySteps = 32767;
constexpr std::int32_t kSameRay = 3;
/// Inverse distances on a scale of logarithms, in two bytes [1/m]; their relative accuracies in
/// one.
constexpr double kLeastInverse = 1e-5, kMostInverse = 1e3;
constexpr double kLeastSigma = 1e-5, kMostSigma = 1e3;
constexpr std::uint16_t kInverseCodes = 65534;
constexpr std::uint8_t kSigmaCodes = 254;
/// Descriptors that differ in more bits are not told by one another.
constexpr int kAlikeBits = 90;
constexpr std::size_t kFarthestAlike = 65534;

/// 0 for what is not above zero, else 1 to codes + 1.
std::uint64_t codeOf(double v, double least, double most, double codes) {
  if (!(v > 0)) return 0;
  const double at = std::log(std::clamp(v, least, most) / least) / std::log(most / least);
  return 1 + static_cast<std::uint64_t>(std::lround(at * codes));
}
double valueOf(std::uint64_t code, double least, double most, double codes) {
  if (code == 0) return 0;
  return least * std::exp(static_cast<double>(code - 1) / codes * std::log(most / least));
}

double stepOf(const CameraCalibration& c) {
  return std::max(kStep_px, std::max(c.width, c.height) / kMostSteps);
}

std::uint64_t stepsOf(float px, double step) {
  if (!std::isfinite(px)) return 0;
  return static_cast<std::uint64_t>(
      std::lround(std::clamp(static_cast<double>(px) / step, 0.0, kMostSteps)));
}

/// Null where the lens cannot be: rays are then in the file in full.
std::shared_ptr<const camera::CameraModel> cameraOf(const CameraCalibration& c) {
  try {
    return camera::makeCamera(c);
  } catch (const std::invalid_argument&) {
    return nullptr;
  }
}

/// Of the pixel; zero if it has none.
Vec3 rayOf(const camera::CameraModel* camera, const Eigen::Vector2f& px) {
  Vec3 ray = Vec3::Zero();
  if (camera == nullptr || !camera->unproject(px.cast<double>(), &ray) || !ray.allFinite()) {
    return Vec3::Zero();
  }
  return ray;
}

Steps stepsOf(const Vec3& ray) {
  Steps out{};
  if (!ray.allFinite()) return out;
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] = static_cast<std::int32_t>(
        std::lround(kRaySteps * std::clamp(ray[static_cast<Eigen::Index>(i)], -1.0, 1.0)));
  }
  return out;
}

/// The most alike of `before`: its place there and 1, or 0.
std::size_t alike(const PlacePoint& p, const std::vector<PlacePoint>& before) {
  std::size_t best = 0;
  int least = kAlikeBits;
  for (std::size_t i = 0; i < std::min(before.size(), kFarthestAlike); ++i) {
    const int bits = places::hammingDistance(p.descriptor, before[i].descriptor);
    if (bits >= least) continue;
    least = bits;
    best = i + 1;
  }
  return best;
}

}  // namespace

PointEncoder::PointEncoder(const CameraCalibration& camera)
    : camera_(cameraOf(camera)), step_px_(stepOf(camera)) {}

void PointEncoder::add(const std::vector<PlacePoint>& points) {
  for (const PlacePoint& p : points) {
    const std::uint64_t x = stepsOf(p.px.x(), step_px_), y = stepsOf(p.px.y(), step_px_);
    put(&column(PointColumn::x_high), x >> 8, 1);
    put(&column(PointColumn::x_low), x, 1);
    put(&column(PointColumn::y_high), y >> 8, 1);
    put(&column(PointColumn::y_low), y, 1);

    const Eigen::Vector2d px =
        step_px_ * Eigen::Vector2d(static_cast<double>(x), static_cast<double>(y));
    const Steps of_pixel = stepsOf(rayOf(camera_.get(), px.cast<float>()));
    Steps ray = stepsOf(p.ray_C.cast<double>());
    bool same = true;
    for (std::size_t i = 0; i < 3; ++i) {
      ray[i] -= of_pixel[i];
      if (std::abs(ray[i]) <= kSameRay) ray[i] = 0;
      same = same && ray[i] == 0;
    }
    put(&column(PointColumn::ray), same ? 0 : 1, 1);
    for (std::size_t i = 0; i < 3 && !same; ++i) {
      put(&column(PointColumn::ray), static_cast<std::uint32_t>(ray[i]), 2);
    }

    const double inverse = static_cast<double>(p.inverse_distance);
    const std::uint64_t code = codeOf(inverse, kLeastInverse, kMostInverse, kInverseCodes);
    put(&column(PointColumn::distance), code, 2);
    if (code > 0) {
      const double sigma = static_cast<double>(p.inverse_distance_sigma) / inverse;
      put(&column(PointColumn::distance), codeOf(sigma, kLeastSigma, kMostSigma, kSigmaCodes), 1);
    }

    const std::size_t like = alike(p, before_);
    put(&column(PointColumn::like), like, 2);
    for (std::size_t i = 0; i < p.descriptor.size(); ++i) {
      const int other = like > 0 ? before_[like - 1].descriptor[i] : 0;
      put(&column(PointColumn::descriptor), static_cast<std::uint64_t>(p.descriptor[i] ^ other), 1);
    }
  }
  before_ = points;
}

void PointEncoder::write(MapWriter* out) const {
  for (const std::string& c : columns_) {
    out->whole(c.size(), 8);
    out->bytes(c.data(), c.size());
  }
}

PointDecoder::PointDecoder(const CameraCalibration& camera, MapReader* in)
    : camera_(cameraOf(camera)), step_px_(stepOf(camera)) {
  for (std::size_t i = 0; i < kPointColumns; ++i) columns_.push_back(in->part());
}

Eigen::Vector3f PointDecoder::readRay(const Eigen::Vector2f& px) {
  MapReader& in = column(PointColumn::ray);
  const std::uint64_t kind = in.whole<1>();
  MapReader::require(kind <= 1, "a ray of no kind");
  const Vec3 of_pixel = rayOf(camera_.get(), px);
  if (kind == 0) return of_pixel.cast<float>();
  const Steps steps = stepsOf(of_pixel);
  Eigen::Vector3f out;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto sum = static_cast<std::int16_t>(
        static_cast<std::uint16_t>(static_cast<std::uint64_t>(steps[i]) + in.whole<2>()));
    out[static_cast<Eigen::Index>(i)] = static_cast<float>(sum / kRaySteps);
  }
  return out;
}

std::vector<PlacePoint> PointDecoder::next(std::size_t count) {
  const std::size_t left = column(PointColumn::descriptor).left() / PlacePoint().descriptor.size();
  MapReader::require(count <= left, "more entries than it has bytes");
  std::vector<PlacePoint> out(count);
  for (PlacePoint& p : out) {
    const auto side = [&](PointColumn high, PointColumn low) {
      const std::uint64_t steps = column(high).whole<1>() << 8 | column(low).whole<1>();
      return static_cast<float>(step_px_ * static_cast<double>(steps));
    };
    p.px.x() = side(PointColumn::x_high, PointColumn::x_low);
    p.px.y() = side(PointColumn::y_high, PointColumn::y_low);
    p.ray_C = readRay(p.px);
    MapReader::require(std::abs(p.ray_C.norm() - 1) < 1e-3f, "a ray that is none");

    MapReader& distance = column(PointColumn::distance);
    const double inverse = valueOf(distance.whole<2>(), kLeastInverse, kMostInverse, kInverseCodes);
    if (inverse > 0) {
      const double sigma = valueOf(distance.whole<1>(), kLeastSigma, kMostSigma, kSigmaCodes);
      p.inverse_distance = static_cast<float>(inverse);
      p.inverse_distance_sigma = static_cast<float>(sigma * inverse);
    }

    const std::uint64_t like = column(PointColumn::like).whole<2>();
    MapReader::require(like <= before_.size(), "a corner like one that is not there");
    column(PointColumn::descriptor).bytes(p.descriptor.data(), p.descriptor.size());
    for (std::size_t i = 0; i < p.descriptor.size() && like > 0; ++i) {
      p.descriptor[i] =
          static_cast<std::uint8_t>(p.descriptor[i] ^ before_[like - 1].descriptor[i]);
    }
  }
  before_ = out;
  return out;
}

void PointDecoder::requireEnd() const {
  for (const MapReader& c : columns_) MapReader::require(c.left() == 0, "it goes on after its end");
}

}  // namespace vir::mission
