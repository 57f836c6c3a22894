#include "vir/mission/mission_map.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>

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
  map.landmarks = {{1, Vec3(1, 2, 3)}, {5, Vec3(-1, 0, 2)}};
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
  EXPECT_EQ(encode(back), bytes);
  ASSERT_EQ(back.keyframes.size(), 3u);
  EXPECT_EQ(back.keyframes[2]->id, 16u);
  EXPECT_EQ(back.keyframes[2]->t, map.keyframes[2]->t);
  EXPECT_EQ(back.keyframes[2]->segment, 1);
  EXPECT_EQ(back.keyframes[1]->T_W_B.p, map.keyframes[1]->T_W_B.p);
  EXPECT_LT(back.keyframes[1]->T_W_B.q.angularDistance(map.keyframes[1]->T_W_B.q), 1e-12);
  EXPECT_EQ(back.keyframes[1]->points[3].descriptor, map.keyframes[1]->points[3].descriptor);
  EXPECT_EQ(back.keyframes[1]->points[3].px, map.keyframes[1]->points[3].px);
  ASSERT_EQ(back.landmarks.size(), 2u);
  EXPECT_EQ(back.landmarks[1].p_W, map.landmarks[1].p_W);
  ASSERT_EQ(back.anchors.size(), 1u);
  EXPECT_EQ(back.anchors[0].p_W, map.anchors[0].p_W);
  EXPECT_EQ(back.anchors[0].covariance, map.anchors[0].covariance);
  EXPECT_EQ(back.calibration.camera.fx, map.calibration.camera.fx);
  EXPECT_EQ(back.calibration.camera.distortion, Distortion::radtan);
  EXPECT_EQ(back.calibration.time_offset_s, 0.004);
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

/// With a checksum that fits: whatever comes out is a map.
TEST(MissionMap, MutatedUnderAGoodChecksum) {
  const std::string bytes = encode(someMap(2, 2));
  // Other ones with --gtest_shuffle --gtest_random_seed=N.
  Random random(11 + static_cast<std::uint64_t>(testing::UnitTest::GetInstance()->random_seed()));
  int read = 0;
  for (int i = 0; i < 100000; ++i) {
    std::string other = bytes;
    const int changes = 1 + static_cast<int>(random.below(4));
    for (int k = 0; k < changes; ++k) {
      const std::size_t at = 20 + random.below(other.size() - 24);
      other[at] = static_cast<char>(random.below(2) == 0 ? 0xFF : random.below(256));
    }
    try {
      const MissionMap map = decode(sealed(other));
      ++read;
      EXPECT_TRUE(encode(map).size() <= bytes.size());
      for (const auto& k : map.keyframes) {
        EXPECT_TRUE(k->T_W_B.p.allFinite());
        EXPECT_NEAR(k->T_W_B.q.norm(), 1, 1e-9);
      }
    } catch (const std::runtime_error&) {
    }
  }
  EXPECT_GT(read, 5000);  // most of a map is descriptors and digits
}

TEST(MissionMap, AFile) {
  const test::TempFolder folder;
  const std::string file = (folder / "a.virmap").string();
  saveMap(someMap(), file);
  EXPECT_EQ(encode(loadMap(file)), encode(someMap()));
  EXPECT_FALSE(fs::exists(file + ".part"));
  // What cannot be written leaves the old map.
  EXPECT_THROW(saveMap(someMap(), (folder / "none/a.virmap").string()), std::runtime_error);
  fs::create_directory(file + ".part");
  EXPECT_THROW(saveMap(someMap(1), file), std::runtime_error);
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

/// Killed anywhere while it saves: what is there is the old map or the new one, and the next save
/// is not disturbed by what was left.
TEST(MissionMap, KilledWhileItSaves) {
  const test::TempFolder folder;
  const std::string file = (folder / "a.virmap").string();
  const MissionMap old = someMap(300), other = someMap(299);
  const std::string of_old = encode(old), of_other = encode(other);
  const auto bytesOf = [](const std::string& name) {
    std::ifstream in(name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  Random random(5);
  int halves = 0;
  for (int i = 0; i < 60; ++i) {
    saveMap(old, file);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (;;) saveMap(other, file);
    }
    ::usleep(static_cast<useconds_t>(500 + random.below(8000)));
    ASSERT_EQ(::kill(child, SIGKILL), 0);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << status;
    EXPECT_NO_THROW(loadMap(file));
    const std::string now = bytesOf(file);
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
  EXPECT_LT((other.landmarks[0].p_W - T * map.landmarks[0].p_W).norm(), 1e-12);
  const MissionMap back = moved(other, T.inverse());
  EXPECT_LT((back.anchors[0].covariance - map.anchors[0].covariance).norm(), 1e-12);
}

}  // namespace
}  // namespace vir::mission
