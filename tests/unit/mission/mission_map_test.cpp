#include "vir/mission/mission_map.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "map_bytes.h"
#include "vir/camera/camera_model.h"
#include "vir/core/little_endian.h"
#include "vir/core/random.h"
#include "vir_test_temp_folder.h"

namespace vir::mission {
namespace {

namespace fs = std::filesystem;

MissionMap someMap(int keyframes = 3, int points = 4) {
  MissionMap map;
  CameraCalibration& c = map.calibration.camera;
  c.width = 752;
  c.height = 480;
  c.fx = 458.654;
  c.fy = 457.296;
  c.cx = 367.215;
  c.cy = 248.375;
  c.distortion = Distortion::radtan;
  c.dist[0] = -0.28;
  map.calibration.T_B_C = Pose(expQuat(Vec3(0.1, 0.2, 0.3)), Vec3(0.01, 0.02, 0.03));
  map.calibration.time_offset_s = 0.004;
  Random random(7);
  for (int i = 0; i < keyframes; ++i) {
    auto k = std::make_shared<PlaceKeyframe>();
    k->id = static_cast<std::uint64_t>(10 + 3 * i);
    k->t = 1400000000000000000 + i * 500000000LL;
    k->segment = i / 2;
    k->T_W_B = Pose(expQuat(Vec3(0.1 * i, 0.2, -0.3)), Vec3(i, -2, 0.5));
    k->T_B_C = map.calibration.T_B_C;
    for (int j = 0; j < points; ++j) {
      PlacePoint p;
      p.px = Eigen::Vector2f(20.5f + static_cast<float>(j), 30.25f);
      p.ray_C = Eigen::Vector3f(0.1f, -0.2f, 1.0f).normalized();
      p.inverse_distance = 0.25f;
      p.inverse_distance_sigma = 0.01f;
      for (std::uint8_t& b : p.descriptor) b = static_cast<std::uint8_t>(random.below(256));
      k->points.push_back(p);
    }
    map.keyframes.push_back(k);
  }
  Anchor a;
  a.id = 7;
  a.has_position = true;
  a.p_W = Vec3(4, 5, 6);
  a.covariance = Vec3(0.01, 0.02, 0.03).asDiagonal();
  a.state = AnchorState::estimated;
  a.bias_m = 0.1;
  map.anchors = {a, Anchor()};  // one without a position is not kept
  return map;
}

std::string sealed(std::string bytes) {
  bytes.resize(bytes.size() - 4);
  const auto crc =
      static_cast<std::uint32_t>(::crc32_z(0, bytesOf(bytes), static_cast<z_size_t>(bytes.size())));
  put(&bytes, crc, 4);
  return bytes;
}

TEST(MissionMap, ComesBackAsItWas) {
  const MissionMap map = someMap();
  const std::string bytes = encode(map);
  const MissionMap back = decode(bytes);
  EXPECT_TRUE(encode(back) == bytes);
  ASSERT_EQ(back.keyframes.size(), 3u);
  EXPECT_EQ(back.keyframes[2]->id, 16u);
  EXPECT_EQ(back.keyframes[2]->t, map.keyframes[2]->t);
  EXPECT_EQ(back.keyframes[2]->segment, 1);
  EXPECT_EQ(back.keyframes[1]->T_W_B.p, map.keyframes[1]->T_W_B.p);
  EXPECT_LT(back.keyframes[1]->T_W_B.q.angularDistance(map.keyframes[1]->T_W_B.q), 1e-12);
  EXPECT_EQ(back.keyframes[1]->points[3].descriptor, map.keyframes[1]->points[3].descriptor);
  EXPECT_EQ(back.keyframes[1]->points[3].px, map.keyframes[1]->points[3].px);
  ASSERT_EQ(back.anchors.size(), 1u);
  EXPECT_EQ(back.anchors[0].p_W, map.anchors[0].p_W);
  EXPECT_EQ(back.anchors[0].covariance, map.anchors[0].covariance);
  EXPECT_EQ(back.calibration.camera.fx, map.calibration.camera.fx);
  EXPECT_EQ(back.calibration.camera.distortion, Distortion::radtan);
  EXPECT_EQ(back.calibration.time_offset_s, 0.004);
}

/// As maps were written before: every number in full, and two map points at the end.
std::string firstVersion(const MissionMap& map) {
  MapWriter w;
  const Calibration& calibration = map.calibration;
  const CameraCalibration& c = calibration.camera;
  w.whole(static_cast<std::uint64_t>(c.width), 4);
  w.whole(static_cast<std::uint64_t>(c.height), 4);
  for (const double v : {c.fx, c.fy, c.cx, c.cy}) w.real(v);
  w.whole(static_cast<std::uint64_t>(c.distortion), 1);
  for (const double v : c.dist) w.real(v);
  w.pose(calibration.T_B_C);
  w.real(calibration.time_offset_s);
  w.real(calibration.readout_s);
  for (const Vec3* v :
       {&calibration.gyro_gain, &calibration.gyro_axes_rad, &calibration.acc_gain}) {
    w.reals(*v);
  }
  w.whole(map.keyframes.size(), 4);
  for (const auto& k : map.keyframes) {
    w.whole(k->id, 8);
    w.whole(static_cast<std::uint64_t>(k->t), 8);
    w.whole(static_cast<std::uint32_t>(k->segment), 4);
    w.pose(k->T_W_B);
    w.pose(k->T_B_C);
    w.whole(k->points.size(), 4);
    for (const PlacePoint& p : k->points) {
      for (const float v : {p.px.x(), p.px.y(), p.ray_C.x(), p.ray_C.y(), p.ray_C.z(),
                            p.inverse_distance, p.inverse_distance_sigma}) {
        w.small(v);
      }
      w.bytes(p.descriptor.data(), p.descriptor.size());
    }
  }
  w.whole(2, 4);
  for (int i = 1; i <= 2; ++i) {
    w.whole(static_cast<std::uint64_t>(i), 8);
    w.reals(Vec3(i, 2, 3));
  }
  w.whole(0, 4);
  std::string out = "VIR-MAP\n";
  put(&out, 1, 4);
  put(&out, w.out().size(), 8);
  return sealed(out + w.out() + "1234");
}

TEST(MissionMap, OfTheFirstVersion) {
  const MissionMap map = someMap();
  const std::string bytes = firstVersion(map);
  const MissionMap back = decode(bytes);
  ASSERT_EQ(back.keyframes.size(), 3u);
  EXPECT_EQ(back.calibration.camera.dist, map.calibration.camera.dist);
  EXPECT_EQ(back.keyframes[2]->points[3].px, map.keyframes[2]->points[3].px);
  EXPECT_EQ(back.keyframes[2]->points[3].ray_C, map.keyframes[2]->points[3].ray_C);
  EXPECT_EQ(back.keyframes[2]->points[3].descriptor, map.keyframes[2]->points[3].descriptor);
  for (std::size_t n = 0; n < bytes.size(); n += 7) {
    EXPECT_THROW(decode(bytes.substr(0, n)), std::runtime_error) << n;
  }
  std::string later = encode(map);
  later[8] = 3;
  try {
    decode(sealed(later));
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("version 3"), std::string::npos) << e.what();
  }
}

/// What is rounded is rounded once, and by less than any use of it can tell.
TEST(MissionMap, RoundsLittleAndOnce) {
  MissionMap map = someMap(1, 0);
  const auto camera = camera::makeCamera(map.calibration.camera);
  auto k = std::make_shared<PlaceKeyframe>(*map.keyframes[0]);
  Random random(3);
  for (int i = 0; i < 400; ++i) {
    PlacePoint p;
    p.px = Eigen::Vector2d(random.uniform(0, 751), random.uniform(0, 479)).cast<float>();
    Vec3 ray;
    // In the corners the lens has no rays; whatever they are told to be comes back as well.
    if (!camera->unproject(p.px.cast<double>(), &ray)) ray = Vec3(0.5, 0.5, 1);
    // A few as of another calibration, or of none.
    if (i % 5 == 0) ray += Vec3(0.002, 0, 0);
    if (i % 7 == 0) ray = Vec3(random.normal(), random.normal(), -random.normal());
    p.ray_C = ray.normalized().cast<float>();
    if (i % 2 == 0) p.inverse_distance = static_cast<float>(std::exp(random.uniform(-8, 4)));
    p.inverse_distance_sigma =
        p.inverse_distance * static_cast<float>(std::exp(random.uniform(-8, 2)));
    for (std::uint8_t& b : p.descriptor) b = static_cast<std::uint8_t>(random.below(256));
    k->points.push_back(p);
  }
  map.keyframes = {k};
  const MissionMap back = decode(encode(map));
  for (std::size_t i = 0; i < k->points.size(); ++i) {
    const PlacePoint &a = k->points[i], &b = back.keyframes[0]->points[i];
    EXPECT_LE((a.px - b.px).cwiseAbs().maxCoeff(), 1.001f / 32);
    EXPECT_LT((a.ray_C - b.ray_C).norm(), 2e-4f) << i;
    EXPECT_NEAR(b.inverse_distance, a.inverse_distance, 2e-4f * a.inverse_distance);
    EXPECT_NEAR(b.inverse_distance_sigma, a.inverse_distance_sigma,
                0.04f * a.inverse_distance_sigma);
    EXPECT_EQ(a.descriptor, b.descriptor);
  }
  EXPECT_TRUE(encode(back) == encode(map));
}

/// Corners that look like those of the keyframe before take little more than what differs.
TEST(MissionMap, TakesFewBytes) {
  MissionMap map = someMap(100, 200);
  Random random(9);
  for (std::size_t i = 1; i < map.keyframes.size(); ++i) {
    auto k = std::make_shared<PlaceKeyframe>(*map.keyframes[i]);
    for (std::size_t j = 0; j < k->points.size(); ++j) {
      PlacePoint& p = k->points[j];
      p.descriptor = map.keyframes[i - 1]->points[j].descriptor;
      for (std::uint8_t& b : p.descriptor) {
        if (random.below(2) == 0) b = static_cast<std::uint8_t>(b ^ (1U << random.below(8)));
      }
      p.inverse_distance = static_cast<float>(random.uniform(0.1, 0.5));
    }
    map.keyframes[i] = k;
  }
  EXPECT_LT(encode(map).size(), 100u * 200u * 26u);
}

/// A file cannot ask for memory that is out of proportion to its size.
TEST(MissionMap, IsNeverPackedByMoreThanASixtyFourth) {
  MissionMap map = someMap(1, 0);
  auto k = std::make_shared<PlaceKeyframe>(*map.keyframes[0]);
  PlacePoint p;
  p.ray_C = Eigen::Vector3f(0, 0, 1);
  k->points.assign(20000, p);
  map.keyframes = {k};
  const std::string bytes = encode(map);
  EXPECT_EQ(decode(bytes).keyframes[0]->points.size(), 20000u);
  std::string greedy = bytes;
  for (int i = 0; i < 8; ++i) greedy[21 + i] = static_cast<char>(i < 6 ? 0xFF : 0);
  EXPECT_THROW(decode(sealed(greedy)), std::runtime_error);
}

TEST(MissionMap, OfNothing) { EXPECT_TRUE(decode(encode(someMap(0))).keyframes.empty()); }

TEST(MissionMap, CutAtEveryByte) {
  const std::string bytes = encode(someMap());
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_THROW(decode(bytes.substr(0, n)), std::runtime_error) << n;
    // And where somebody has made a checksum and a length for what is left.
    if (n < 24) continue;
    std::string cut = bytes.substr(0, n);
    const std::uint64_t left = n - 24;
    for (std::size_t i = 0; i < 8; ++i) cut[12 + i] = static_cast<char>(left >> (8 * i));
    EXPECT_THROW(decode(sealed(cut)), std::runtime_error) << n;
  }
  EXPECT_THROW(decode(bytes + "x"), std::runtime_error);
}

TEST(MissionMap, EveryChangedByteIsSeen) {
  const std::string bytes = encode(someMap());
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    for (const int bit : {0, 3, 7}) {
      std::string other = bytes;
      other[n] = static_cast<char>(other[n] ^ (1 << bit));
      EXPECT_THROW(decode(other), std::runtime_error) << n;
    }
  }
}

/// The same map with its payload written as it is, without zlib, which has a checksum of its own.
std::string unpacked(const std::string& bytes) {
  const std::uint64_t size = unsignedAt<8>(bytesOf(bytes) + 21);
  std::string plain(size, '\0');
  auto out = static_cast<uLongf>(size);
  EXPECT_EQ(::uncompress(reinterpret_cast<Bytef*>(plain.data()), &out, bytesOf(bytes) + 29,
                         static_cast<uLong>(bytes.size() - 33)),
            Z_OK);
  std::string file = bytes.substr(0, 12);
  put(&file, 9 + size, 8);
  put(&file, 0, 1);
  put(&file, size, 8);
  return sealed(file + plain + "1234");
}

/// With a checksum that fits: whatever comes out is a map.
void mutate(const std::string& bytes, int times, int readable) {
  // Other ones with --gtest_shuffle --gtest_random_seed=N.
  Random random(11 + static_cast<std::uint64_t>(testing::UnitTest::GetInstance()->random_seed()));
  int read = 0;
  for (int i = 0; i < times; ++i) {
    std::string other = bytes;
    const int changes = 1 + static_cast<int>(random.below(4));
    for (int k = 0; k < changes; ++k) {
      const std::size_t at = 20 + random.below(other.size() - 24);
      other[at] = static_cast<char>(random.below(2) == 0 ? 0xFF : random.below(256));
    }
    try {
      const MissionMap map = decode(sealed(other));
      ++read;
      std::size_t points = 0;
      for (const auto& k : map.keyframes) points += k->points.size();
      EXPECT_LE(points, 4u);
      for (const auto& k : map.keyframes) {
        EXPECT_TRUE(k->T_W_B.p.allFinite());
        EXPECT_NEAR(k->T_W_B.q.norm(), 1, 1e-9);
      }
    } catch (const std::runtime_error&) {
    }
  }
  EXPECT_GT(read, readable);
}

TEST(MissionMap, MutatedUnderAGoodChecksum) {
  const std::string bytes = encode(someMap(2, 2));
  ASSERT_TRUE(encode(decode(unpacked(bytes))) == bytes);
  mutate(bytes, 30000, 0);
  mutate(unpacked(bytes), 100000, 5000);  // most of a map is descriptors and digits
  mutate(firstVersion(someMap(2, 2)), 30000, 1500);
}

TEST(MissionMap, AFile) {
  const test::TempFolder folder;
  const std::string file = (folder / "a.virmap").string();
  saveMap(someMap(), file);
  EXPECT_TRUE(encode(loadMap(file)) == encode(someMap()));
  EXPECT_FALSE(fs::exists(file + ".part"));
  // What cannot be written leaves the old map.
  EXPECT_THROW(saveMap(someMap(), (folder / "none/a.virmap").string()), std::runtime_error);
  fs::create_directory(file + ".part");
  EXPECT_THROW(saveMap(someMap(1), file), std::runtime_error);
  EXPECT_EQ(loadMap(file).keyframes.size(), 3u);
  // Nor does one without a place take the place of it.
  fs::remove(file + ".part");
  EXPECT_THROW(saveMap(someMap(0), file), std::runtime_error);
  EXPECT_EQ(loadMap(file).keyframes.size(), 3u);
  EXPECT_THROW(loadMap(folder.path().string()), std::runtime_error);
  EXPECT_THROW(loadMap((folder / "b.virmap").string()), std::runtime_error);
  std::ofstream((folder / "text.virmap").string()) << "t,x,y,z and so on, longer than a head";
  try {
    loadMap((folder / "text.virmap").string());
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("no map of vir-slam"), std::string::npos) << e.what();
  }
}

/// Killed anywhere while it saves, and as it begins to write: what is there is the old map or the
/// new one, and the next save is not disturbed by what was left.
TEST(MissionMap, KilledWhileItSaves) {
  using namespace std::chrono;
  const test::TempFolder folder;
  const std::string file = (folder / "a.virmap").string();
  const MissionMap old = someMap(300), other = someMap(299);
  const std::string of_old = encode(old), of_other = encode(other);
  Random random(5);
  int halves = 0;
  for (int i = 0; i < 60; ++i) {
    saveMap(old, file);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    while (child == 0) saveMap(other, file);
    const bool writing = i % 2 == 1;  // which is a small part of it
    const auto end =
        steady_clock::now() + microseconds(writing ? 60000000 : 500 + random.below(8000));
    while (steady_clock::now() < end && !(writing && fs::exists(file + ".part"))) continue;
    ASSERT_EQ(::kill(child, SIGKILL), 0);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << status;
    EXPECT_NO_THROW(loadMap(file));
    const std::string now = test::readText(file);
    ASSERT_TRUE(now == of_old || now == of_other) << i;
    halves += fs::exists(file + ".part");
  }
  EXPECT_GT(halves, 0);  // else nobody was killed in the middle
}

TEST(MissionMap, OfAnotherCamera) {
  const CameraCalibration c = someMap().calibration.camera;
  EXPECT_EQ(cameraDifference(c, c), "");
  CameraCalibration other = c;
  other.fx *= 1.005;  // calibrated again
  other.cx += 3;
  EXPECT_EQ(cameraDifference(c, other), "");
  other = c;
  other.width = 640;
  EXPECT_EQ(cameraDifference(c, other), "image width 752 in the map, 640 now");
  other = c;
  other.fy *= 1.1;
  EXPECT_NE(cameraDifference(c, other), "");
  other = c;
  other.distortion = Distortion::equidistant;
  EXPECT_NE(cameraDifference(c, other), "");
}

TEST(MissionMap, Moved) {
  const MissionMap map = someMap();
  const LevelTransform T{0.5, Vec3(1, 2, 3)};
  const MissionMap other = moved(map, T);
  EXPECT_LT((other.keyframes[1]->T_W_B.p - T * map.keyframes[1]->T_W_B.p).norm(), 1e-12);
  const MissionMap back = moved(other, T.inverse());
  EXPECT_LT((back.anchors[0].covariance - map.anchors[0].covariance).norm(), 1e-12);
}

}  // namespace
}  // namespace vir::mission
