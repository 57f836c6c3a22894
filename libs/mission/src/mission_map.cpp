#include "vir/mission/mission_map.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "map_bytes.h"
#include "map_points.h"

namespace vir::mission {
namespace {

constexpr std::array<char, 8> kMagic{'V', 'I', 'R', '-', 'M', 'A', 'P', '\n'};
constexpr std::uint32_t kVersion = 2, kOldest = 1;
constexpr std::size_t kHead = kMagic.size() + 4 + 8, kChecksum = 4;
constexpr std::size_t kPointBytes = 7 * 4 + 32, kKeyframeBytes = 8 + 8 + 4 + 2 * 56 + 4,
                      kLandmarkBytes = 8 + 24, kAnchorBytes = 8 + 24 + 72 + 16 + 1;
/// How the payload is written: as it is, or by zlib if it does not become shorter than this share
/// of itself, so that a file can never ask for more memory than that times its size.
constexpr std::uint8_t kPlain = 0, kZlib = 1;
constexpr std::uint64_t kMostShrunk = 64;
constexpr int kZlibLevel = 6;
constexpr int kLargestSide = 1 << 16;  // [px]

std::uint32_t crcOf(const std::string& bytes, std::size_t size) {
  return static_cast<std::uint32_t>(::crc32_z(0, bytesOf(bytes), size));
}

void write(const Calibration& c, MapWriter* w) {
  const CameraCalibration& k = c.camera;
  w->whole(static_cast<std::uint64_t>(k.width), 4);
  w->whole(static_cast<std::uint64_t>(k.height), 4);
  for (const double v : {k.fx, k.fy, k.cx, k.cy}) w->real(v);
  w->whole(static_cast<std::uint64_t>(k.distortion), 1);
  for (const double v : k.dist) w->real(v);
  w->pose(c.T_B_C);
  w->real(c.time_offset_s);
  w->real(c.readout_s);
  for (const Vec3* v : {&c.gyro_gain, &c.gyro_axes_rad, &c.acc_gain}) w->reals(*v);
}

Calibration readCalibration(MapReader* r) {
  Calibration c;
  CameraCalibration& k = c.camera;
  k.width = static_cast<int>(r->whole<4>());
  k.height = static_cast<int>(r->whole<4>());
  r->require(k.width > 0 && k.width <= kLargestSide && k.height > 0 && k.height <= kLargestSide,
             "an image size that cannot be");
  for (double* v : {&k.fx, &k.fy, &k.cx, &k.cy}) *v = r->real();
  r->require(k.fx > 0 && k.fy > 0, "a focal length that cannot be");
  const std::uint64_t lens = r->whole<1>();
  r->require(lens <= static_cast<std::uint64_t>(Distortion::omni), "an unknown lens");
  k.distortion = static_cast<Distortion>(lens);
  for (double& v : k.dist) v = r->real();
  c.T_B_C = r->pose();
  c.time_offset_s = r->real();
  c.readout_s = r->real();
  for (Vec3* v : {&c.gyro_gain, &c.gyro_axes_rad, &c.acc_gain}) r->reals(v);
  return c;
}

void writeHead(const PlaceKeyframe& k, MapWriter* w) {
  w->whole(k.id, 8);
  w->whole(static_cast<std::uint64_t>(k.t), 8);
  w->whole(static_cast<std::uint32_t>(k.segment), 4);
  w->pose(k.T_W_B);
  w->pose(k.T_B_C);
  w->whole(k.points.size(), 4);
}

/// `count`: of its corners, which are not read yet.
std::shared_ptr<PlaceKeyframe> readHead(MapReader* r, std::size_t* count) {
  auto k = std::make_shared<PlaceKeyframe>();
  k->id = r->whole<8>();
  k->t = static_cast<TimeNs>(r->whole<8>());
  k->segment = static_cast<std::int32_t>(r->whole<4>());
  k->T_W_B = r->pose();
  k->T_B_C = r->pose();
  *count = static_cast<std::size_t>(r->whole<4>());
  return k;
}

/// As of version 1.
void readPoints(MapReader* r, std::vector<PlacePoint>* points) {
  for (PlacePoint& p : *points) {
    for (float* v : {&p.px.x(), &p.px.y(), &p.ray_C.x(), &p.ray_C.y(), &p.ray_C.z(),
                     &p.inverse_distance, &p.inverse_distance_sigma}) {
      *v = r->small();
    }
    r->require(std::abs(p.ray_C.norm() - 1) < 1e-3f, "a ray that is none");
    r->bytes(p.descriptor.data(), p.descriptor.size());
  }
}

void write(const Anchor& a, MapWriter* w) {
  w->whole(a.id, 8);
  w->reals(a.p_W);
  w->reals(a.covariance);
  w->real(a.bias_m);
  w->real(a.bias_sigma_m);
  w->whole(static_cast<std::uint64_t>(a.state), 1);
}

Anchor readAnchor(MapReader* r) {
  Anchor a;
  a.id = r->whole<8>();
  a.has_position = true;
  r->reals(&a.p_W);
  r->reals(&a.covariance);
  a.bias_m = r->real();
  a.bias_sigma_m = r->real();
  const std::uint64_t state = r->whole<1>();
  r->require(state <= static_cast<std::uint64_t>(AnchorState::moved), "an unknown anchor state");
  a.state = static_cast<AnchorState>(state);
  return a;
}

void requireRising(const MissionMap& map) {
  for (std::size_t i = 1; i < map.keyframes.size(); ++i) {
    MapReader::require(map.keyframes[i - 1]->id < map.keyframes[i]->id, "ids do not rise");
  }
}

void readAnchors(MapReader* r, MissionMap* map) {
  const std::size_t anchors = r->count(kAnchorBytes);
  for (std::size_t i = 0; i < anchors; ++i) {
    map->anchors.push_back(readAnchor(r));
    r->require(i == 0 || map->anchors[i - 1].id < map->anchors[i].id, "anchors are out of order");
  }
}

/// Version 1: all one after the other, map points once more by themselves.
MissionMap readFirstVersion(MapReader* r) {
  MissionMap map;
  map.calibration = readCalibration(r);
  const std::size_t keyframes = r->count(kKeyframeBytes);
  for (std::size_t i = 0; i < keyframes; ++i) {
    std::size_t count = 0;
    const auto k = readHead(r, &count);
    r->require(count <= r->left() / kPointBytes, "more entries than it has bytes");
    k->points.resize(count);
    readPoints(r, &k->points);
    map.keyframes.push_back(k);
  }
  requireRising(map);
  for (std::size_t left = r->count(kLandmarkBytes); left > 0; --left) {
    r->whole<8>();
    Vec3 p_M;
    r->reals(&p_M);
  }
  readAnchors(r, &map);
  r->require(r->left() == 0, "it goes on after its end");
  return map;
}

MissionMap readPayload(MapReader* r) {
  MissionMap map;
  map.calibration = readCalibration(r);
  std::vector<std::shared_ptr<PlaceKeyframe>> keyframes(r->count(kKeyframeBytes));
  std::vector<std::size_t> counts(keyframes.size());
  for (std::size_t i = 0; i < keyframes.size(); ++i) keyframes[i] = readHead(r, &counts[i]);
  readAnchors(r, &map);
  PointDecoder points(map.calibration.camera, r);
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    keyframes[i]->points = points.next(counts[i]);
    map.keyframes.push_back(keyframes[i]);
  }
  points.requireEnd();
  requireRising(map);
  r->require(r->left() == 0, "it goes on after its end");
  return map;
}

std::string payloadOf(const MissionMap& map) {
  MapWriter payload;
  write(map.calibration, &payload);
  payload.whole(map.keyframes.size(), 4);
  PointEncoder points(map.calibration.camera);
  for (const auto& k : map.keyframes) {
    writeHead(*k, &payload);
    points.add(k->points);
  }
  std::vector<const Anchor*> known;
  for (const Anchor& a : map.anchors) {
    if (a.has_position) known.push_back(&a);
  }
  payload.whole(known.size(), 4);
  for (const Anchor* a : known) write(*a, &payload);
  points.write(&payload);
  return std::move(payload.out());
}

std::string packed(const std::string& plain) {
  MapWriter out;
  std::string shorter(::compressBound(plain.size()), '\0');
  auto size = static_cast<uLongf>(shorter.size());
  const bool fits = ::compress2(reinterpret_cast<Bytef*>(shorter.data()), &size, bytesOf(plain),
                                static_cast<uLong>(plain.size()), kZlibLevel) == Z_OK &&
                    size < plain.size() && plain.size() <= kMostShrunk * size;
  out.whole(fits ? kZlib : kPlain, 1);
  out.whole(plain.size(), 8);
  if (fits) {
    out.bytes(shorter.data(), size);
  } else {
    out.bytes(plain.data(), plain.size());
  }
  return std::move(out.out());
}

std::string unpacked(MapReader* r) {
  const std::uint64_t how = r->whole<1>(), size = r->whole<8>();
  r->require(how <= kZlib, "packed in a way that is not known");
  r->require(size <= (how == kZlib ? kMostShrunk : 1) * r->left(), "more than it has bytes for");
  std::string file(r->left(), '\0');
  r->bytes(file.data(), file.size());
  if (how == kPlain) {
    r->require(size == file.size(), "it goes on after its end");
    return file;
  }
  std::string plain(static_cast<std::size_t>(size), '\0');
  auto out = static_cast<uLongf>(plain.size());
  auto in = static_cast<uLong>(file.size());
  const int done = ::uncompress2(reinterpret_cast<Bytef*>(plain.data()), &out, bytesOf(file), &in);
  r->require(done == Z_OK && out == plain.size() && in == file.size(), "it cannot be unpacked");
  return plain;
}

}  // namespace

std::string encode(const MissionMap& map) {
  const std::string payload = packed(payloadOf(map));
  MapWriter file;
  file.bytes(kMagic.data(), kMagic.size());
  file.whole(kVersion, 4);
  file.whole(payload.size(), 8);
  file.out() += payload;
  file.whole(crcOf(file.out(), file.out().size()), 4);
  return std::move(file.out());
}

MissionMap decode(const std::string& bytes) {
  if (bytes.size() < kHead + kChecksum ||
      !std::equal(kMagic.begin(), kMagic.end(), bytes.begin())) {
    throw std::runtime_error("it is no map of vir-slam");
  }
  const std::uint8_t* at = bytesOf(bytes) + kMagic.size();
  const std::uint64_t version = unsignedAt<4>(at), size = unsignedAt<8>(at + 4);
  if (version < kOldest || version > kVersion) {
    throw std::runtime_error("it is of version " + std::to_string(version) +
                             ", and this program reads versions " + std::to_string(kOldest) +
                             " to " + std::to_string(kVersion));
  }
  const std::size_t checked = bytes.size() - kChecksum;
  if (size != checked - kHead) {
    throw std::runtime_error("it is damaged: " + std::to_string(checked - kHead) + " bytes of " +
                             std::to_string(size));
  }
  if (unsignedAt<4>(bytesOf(bytes) + checked) != crcOf(bytes, checked)) {
    throw std::runtime_error("it is damaged: the checksum does not fit");
  }
  MapReader reader(bytesOf(bytes) + kHead, checked - kHead);
  if (version == 1) return readFirstVersion(&reader);
  const std::string payload = unpacked(&reader);
  MapReader inside(bytesOf(payload), payload.size());
  return readPayload(&inside);
}

void addMapPoints(const PlaceKeyframe& keyframe, const Pose& T_M_B, double max_sigma,
                  std::vector<Landmark>* points) {
  const Pose T_M_C = T_M_B * keyframe.T_B_C;
  for (const PlacePoint& p : keyframe.points) {
    const double inverse = static_cast<double>(p.inverse_distance);
    const double sigma = static_cast<double>(p.inverse_distance_sigma);
    if (!(inverse > 0) || !(sigma < max_sigma * inverse)) continue;
    const Vec3 p_M = T_M_C * Vec3(p.ray_C.cast<double>() / inverse);
    if (p_M.allFinite()) points->push_back({points->size() + 1, p_M});
  }
}

std::string cameraDifference(const CameraCalibration& map, const CameraCalibration& camera) {
  const auto said = [](const char* what, double a, double b) {
    char text[160];
    std::snprintf(text, sizeof text, "%s %g in the map, %g now", what, a, b);
    return std::string(text);
  };
  if (map.width != camera.width) return said("image width", map.width, camera.width);
  if (map.height != camera.height) return said("image height", map.height, camera.height);
  if (map.distortion != camera.distortion) return "another kind of lens";
  // Calibrations of one camera differ by less; the corners of another are elsewhere.
  constexpr double kFocal = 0.03, kCentre = 0.03;
  for (const auto& [a, b, what] : {std::tuple(map.fx, camera.fx, "focal length"),
                                   std::tuple(map.fy, camera.fy, "focal length")}) {
    if (std::abs(a - b) > kFocal * a) return said(what, a, b);
  }
  for (const auto& [a, b] : {std::pair(map.cx, camera.cx), std::pair(map.cy, camera.cy)}) {
    if (std::abs(a - b) > kCentre * map.width) return said("principal point", a, b);
  }
  return {};
}

MissionMap moved(const MissionMap& map, const LevelTransform& T) {
  MissionMap out = map;
  const Pose pose = T.pose();
  const Mat3 R = pose.R();
  for (auto& k : out.keyframes) {
    auto copy = std::make_shared<PlaceKeyframe>(*k);
    copy->T_W_B = pose * copy->T_W_B;
    k = std::move(copy);
  }
  for (Anchor& a : out.anchors) {
    a.p_W = T * a.p_W;
    a.mirror_p_W = T * a.mirror_p_W;
    a.covariance = R * a.covariance * R.transpose();
  }
  return out;
}

}  // namespace vir::mission
