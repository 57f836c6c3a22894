/// Recordings that are not laid out as EuRoC's: other columns, separators, stamps, names.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "image_store.h"
#include "image_survey.h"
#include "input_error.h"
#include "recording.h"
#include "vir_test_euroc_folder.h"

namespace vir::euroc {
namespace {

using test::EurocFolder;

struct Content {
  std::vector<ImuSample> imu;
  std::vector<RangeRow> ranges;
  std::vector<std::string> labels;  ///< of the ranges
  std::vector<Vec3> antennas;       ///< of the ranges
  std::vector<PoseRow> truth;
  std::vector<std::string> images;  ///< where they are
  std::string notes;
};

Content read(const EurocFolder& f, const std::string& antenna = "",
             const std::vector<double>& lever_arm_m = {0, 0, 0}) {
  EurocOptions o;
  o.lever_arm_m = lever_arm_m;
  o.source = f.root().string();
  o.antenna = antenna;
  Content c;
  ProblemLog log;
  Recording recording(o, &log);
  Event e;
  while (recording.next(&e)) {
    if (auto* imu = std::get_if<ImuSample>(&e.what)) c.imu.push_back(*imu);
    if (auto* range = std::get_if<RangeRow>(&e.what)) {
      c.ranges.push_back(*range);
      c.labels.push_back(recording.rangeStreams()[e.stream].label);
      c.antennas.push_back(recording.rangeStreams()[e.stream].antenna);
    }
    if (auto* pose = std::get_if<PoseRow>(&e.what)) c.truth.push_back(*pose);
    if (auto* image = std::get_if<ImageRow>(&e.what)) {
      c.images.push_back(imageFile(recording.folder().cameras[0].dir, image->file));
    }
  }
  for (const std::string& m : log.messages()) c.notes += m + "\n";
  return c;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Every row of a table through `change`, its fields without the stamp.
template <typename Change>
void rewrite(const EurocFolder& f, const std::string& name, const std::string& header,
             Change change) {
  std::istringstream in(f.read(name));
  std::string text = header.empty() ? "" : header + "\n", line;
  for (int i = -1; std::getline(in, line); ++i) {
    if (i < 0) continue;
    std::vector<std::string> v;
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) v.push_back(field);
    text += change(i, v) + "\n";
  }
  f.write(name, text);
}

using Fields = std::vector<std::string>;

TEST(AnyLayout, ImuColumnsByNameInAnyOrder) {
  const EurocFolder f;
  rewrite(f, "imu0/data.csv", ";timestamp;ax;ay;az;gx;gy;gz", [](int i, const Fields& v) {
    return std::to_string(i) + ";" + v[0] + ";" + v[4] + ";" + v[5] + ";" + v[6] + ";" + v[1] +
           ";" + v[2] + ";" + v[3];
  });
  const Content c = read(f);
  ASSERT_EQ(c.imu.size(), static_cast<std::size_t>(f.imuRows()));
  EXPECT_EQ(c.imu[7].t, f.o.start_ns + 7 * f.o.imu_period_ns);
  EXPECT_EQ(c.imu[7].gyro, Vec3(0.007, 0.02, 0.03));
  EXPECT_EQ(c.imu[7].acc, Vec3(0.1, 0.2, 9.81));
  EXPECT_TRUE(contains(c.notes, "by its header the gyro is in columns 6 7 8")) << c.notes;
}

TEST(AnyLayout, StampsInMilliseconds) {
  test::EurocFolderOptions o;
  o.start_ns = 1403636580000000000;
  const EurocFolder f(o);
  for (const char* name : {"imu0/data.csv", "cam0/data.csv", "uwb0/data.csv"}) {
    rewrite(f, name, "#timestamp [ns]", [](int, Fields v) {
      std::string out = v[0].substr(0, 13);
      for (std::size_t i = 1; i < v.size(); ++i) out += "," + v[i];
      return out;
    });
  }
  const Content c = read(f);
  ASSERT_EQ(c.imu.size(), static_cast<std::size_t>(f.imuRows()));
  EXPECT_EQ(c.imu[1].t, 1403636580005000000);
  EXPECT_EQ(c.images.size(), 10u);
  EXPECT_EQ(c.ranges.size(), 10u);
  EXPECT_TRUE(contains(c.notes, "imu0/data.csv: the stamps are in ms")) << c.notes;
}

TEST(AnyLayout, ImagesByAnyName) {
  const std::vector<std::pair<std::string, std::function<std::string(const Fields&)>>> lists{
      {"a folder in front", [](const Fields& v) { return v[0] + ",data/" + v[1]; }},
      {"an absolute path", [](const Fields& v) { return v[0] + ",/home/me/cam0/data/" + v[1]; }},
      {"no ending", [](const Fields& v) { return v[0] + "," + v[1].substr(0, v[1].size() - 4); }},
      {"stamps alone", [](const Fields& v) { return v[0]; }},
      {"semicolons", [](const Fields& v) { return v[0] + ";" + v[1]; }}};
  for (const auto& [what, change] : lists) {
    const EurocFolder f;
    rewrite(f, "cam0/data.csv", "#timestamp [ns],filename",
            [&change = change](int, const Fields& v) { return change(v); });
    const Content c = read(f);
    ASSERT_EQ(c.images.size(), 10u) << what;
    EXPECT_TRUE(std::filesystem::equivalent(c.images[3], f.imageFile(3))) << what;
  }
}

TEST(AnyLayout, AnchorsHaveNames) {
  const EurocFolder f;
  rewrite(f, "uwb0/data.csv", "#t,id,r", [](int i, const Fields& v) {
    return v[0] + "," + (i % 3 == 0 ? "0x84" : i % 3 == 1 ? "200A" : "9412036502") + "," + v[2];
  });
  const Content c = read(f);
  ASSERT_EQ(c.ranges.size(), 10u);
  EXPECT_EQ(c.ranges[0].anchor, 0x84);
  EXPECT_EQ(c.ranges[1].anchor, 1000000);
  EXPECT_EQ(c.ranges[2].anchor, 1000001);
  EXPECT_TRUE(contains(c.notes, "anchor 200A is 1000000")) << c.notes;
}

TEST(AnyLayout, AntennasAreToldApart) {
  const EurocFolder f;
  rewrite(f, "uwb0/data.csv", "#timestamp [ns],anchor_id,range [m],antenna",
          [](int i, const Fields& v) {
            return v[0] + ",0," + v[2] + "," + (i % 2 == 0 ? "200A" : "200B");
          });
  const Content all = read(f);
  ASSERT_EQ(all.ranges.size(), 10u);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(all.ranges[i].antenna, i % 2 == 0 ? "200A" : "200B");
    EXPECT_EQ(all.labels[i], i % 2 == 0 ? "UWB0" : "UWB1");
  }
  EXPECT_TRUE(contains(all.notes, "2 antennas (200A is UWB0, 200B is UWB1)")) << all.notes;
  EXPECT_TRUE(contains(all.notes, "only one position is known")) << all.notes;
  const Content one = read(f, "200B");
  ASSERT_EQ(one.ranges.size(), 5u);
  EXPECT_EQ(one.ranges[0].antenna, "200B");
  EXPECT_EQ(one.labels[0], "UWB0");
}

TEST(AnyLayout, EachAntennaMayHaveItsPlace) {
  const EurocFolder f;
  rewrite(f, "uwb0/data.csv", "#timestamp [ns],anchor_id,range [m],tag",
          [](int i, const Fields& v) {
            return v[0] + ",0," + v[2] + "," + (i % 2 == 0 ? "left" : "right");
          });
  const Content c = read(f, "", {0.1, 0.2, 0.3, -0.1, -0.2, 0.4});
  ASSERT_EQ(c.ranges.size(), 10u);
  EXPECT_EQ(c.antennas[0], Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(c.antennas[1], Vec3(-0.1, -0.2, 0.4));
  EXPECT_FALSE(contains(c.notes, "only one position is known")) << c.notes;
  EXPECT_THROW(read(f, "", {0.1, 0.2}), InputError);
}

TEST(AnyLayout, AnAntennaThatComesLateIsCounted) {
  const EurocFolder f;
  std::string text = "#timestamp [ns],anchor_id,range [m],antenna\n";
  for (int i = 0; i < 500; ++i) {
    const std::string name = i == 450 ? "C" : i % 2 == 0 ? "A" : "B";
    text += std::to_string(f.imageStamp(0) + i * 1000) + ",0,2," + name + "\n";
  }
  f.write("uwb0/data.csv", text);
  EurocOptions o;
  o.source = f.root().string();
  ProblemLog log;
  Recording recording(o, &log);
  long ranges = 0;
  for (Event e; recording.next(&e);) ranges += std::holds_alternative<RangeRow>(e.what) ? 1 : 0;
  EXPECT_EQ(ranges, 499);
  EXPECT_EQ(log.get("range_of_another_antenna"), 1);
}

TEST(AnyLayout, GroundTruthInAnyOrderAndNotation) {
  const std::string folder = "state_groundtruth_estimate0/data.csv";
  const EurocFolder reference;
  const Content expected = read(reference);
  const std::vector<std::pair<std::string, std::function<std::string(const Fields&)>>> forms{
      {"#timestamp,x,y,z,qx,qy,qz,qw",
       [](const Fields& v) {
         return v[0] + "," + v[1] + "," + v[2] + "," + v[3] + "," + v[5] + "," + v[6] + "," + v[7] +
                "," + v[4];
       }},
      {"", [](const Fields& v) {  // TUM, in seconds with an exponent
         return v[0].substr(0, 1) + "." + v[0].substr(1) + "e9 " + v[1] + " " + v[2] + " " + v[3] +
                " " + v[5] + " " + v[6] + " " + v[7] + " " + v[4];
       }}};
  for (const auto& [header, change] : forms) {
    const EurocFolder f;
    rewrite(f, folder, header, [&, c = change](int, const Fields& v) { return c(v); });
    const Content c = read(f);
    ASSERT_EQ(c.truth.size(), expected.truth.size()) << header << c.notes;
    EXPECT_EQ(c.truth[9].t, expected.truth[9].t);
    EXPECT_EQ(c.truth[9].T_W_B.q.coeffs(), expected.truth[9].T_W_B.q.coeffs());
  }
}

TEST(AnyLayout, PositionsAloneAreTaken) {
  const EurocFolder f;
  const std::string folder = "state_groundtruth_estimate0/data.csv";
  rewrite(f, folder, "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m]",
          [](int, const Fields& v) { return v[0] + "," + v[1] + ",2553112.02," + v[3]; });
  std::filesystem::create_directories(f.mav0() / "leica0");
  std::filesystem::rename(f.mav0() / folder, f.mav0() / "leica0/data.csv");
  std::filesystem::remove_all(f.mav0() / "state_groundtruth_estimate0");
  const Content c = read(f);
  ASSERT_EQ(c.truth.size(), static_cast<std::size_t>(f.imuRows()));
  EXPECT_FALSE(c.truth[3].has_attitude);
  EXPECT_EQ(c.truth[3].T_W_B.p.y(), 2553112.02);
  EXPECT_TRUE(contains(c.notes, "positions only")) << c.notes;
}

/// What becomes of `pixels`, of which all images are made.
std::vector<int> storedPixels(const std::vector<int>& pixels, std::string* said,
                              int depth = CV_16U) {
  const EurocFolder f;
  cv::Mat m(48, 64, CV_16UC1);
  for (int i = 0; i < m.rows * m.cols; ++i) {
    m.at<std::uint16_t>(i / m.cols, i % m.cols) =
        static_cast<std::uint16_t>(pixels[static_cast<std::size_t>(i) % pixels.size()]);
  }
  m.convertTo(m, depth);
  for (int i = 0; i < 10; ++i) cv::imwrite(f.imageFile(i).string(), m);
  EurocOptions o;
  o.source = f.root().string();
  ProblemLog log;
  const Recording recording(o, &log);
  *said = recording.cameras()[0].stretch.said;
  ImageStore store(ImageMode::embed, "", "CAM0", 64, 48, &log);
  const Stretch& stretch = recording.cameras()[0].stretch;
  store.setStretch(stretch.black, stretch.white, stretch.eight_bit);
  StoredImage out;
  EXPECT_TRUE(store.store(1, f.imageFile(0).string(), "", &out));
  std::vector<int> values;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    values.push_back(out.pixels.at<std::uint8_t>(0, static_cast<int>(i)));
  }
  return values;
}

TEST(AnyLayout, SixteenBitsAreStretchedByWhatTheRecordingHolds) {
  std::string said;
  // 16 bits: the division by 257 that it always was.
  EXPECT_EQ(storedPixels({0, 257 * 100, 65535}, &said), (std::vector<int>{0, 100, 255}));
  EXPECT_EQ(said, "");
  // 12 bits: the pixels of an 8-bit image times 16 come back.
  EXPECT_EQ(storedPixels({0, 16 * 100, 16 * 255}, &said), (std::vector<int>{0, 100, 254}));
  EXPECT_EQ(said, "images of 12 bits");
  // Thermal: 765 counts of 14 bits fill five sixths of the grey values.
  const std::vector<int> thermal = storedPixels({7400, 7783, 8165}, &said);
  EXPECT_NEAR(thermal[0], 21, 3);
  EXPECT_NEAR(thermal[1], 128, 3);
  EXPECT_NEAR(thermal[2], 234, 3);
  EXPECT_TRUE(contains(said, "stretched")) << said;
}

TEST(AnyLayout, EightBitsAreStretchedOnlyWhereTheWholeRecordingIsDark) {
  std::string said;
  const std::vector<int> dark = storedPixels({0, 8, 15}, &said, CV_8U);
  EXPECT_EQ(dark, (std::vector<int>{0, 120, 225}));
  EXPECT_TRUE(contains(said, "images that hold 0 to 15 of 255 were stretched")) << said;
  EXPECT_EQ(storedPixels({0, 8, 32}, &said, CV_8U), (std::vector<int>{0, 8, 32}));
  EXPECT_EQ(said, "");
  // A lens cap: noise stays noise.
  EXPECT_EQ(storedPixels({0, 1, 5}, &said, CV_8U), (std::vector<int>{0, 1, 5}));
  EXPECT_EQ(said, "");
}

TEST(AnyLayout, OneBrightImageIsEnoughForImagesToStayAsTheyAre) {
  const EurocFolder f;
  for (int i = 0; i < 10; ++i) {
    cv::Mat m(48, 64, CV_8UC1, cv::Scalar(i == 6 ? 200 : 0));
    m.colRange(0, 20) = cv::Scalar(15);
    cv::imwrite(f.imageFile(i).string(), m);
  }
  EurocOptions o;
  o.source = f.root().string();
  ProblemLog log;
  const Recording recording(o, &log);
  EXPECT_FALSE(recording.cameras()[0].stretch.eight_bit);
}

TEST(AnyLayout, ImagesOfHalfTheSizeScaleTheIntrinsics) {
  const EurocFolder f;
  for (int i = 0; i < 10; ++i) {
    cv::imwrite(f.imageFile(i).string(), cv::Mat(24, 32, CV_8UC1, cv::Scalar(100)));
  }
  EurocOptions o;
  o.source = f.root().string();
  ProblemLog log;
  const Recording recording(o, &log);
  const CameraCalibration& c = recording.cameras()[0].calibration.camera;
  EXPECT_EQ(c.width, 32);
  EXPECT_DOUBLE_EQ(c.fx, 40.5 / 2);
  EXPECT_DOUBLE_EQ(c.cx, (31.25 + 0.5) / 2 - 0.5);
  EXPECT_TRUE(contains(log.messages().at(0), "scaled by 0.5")) << log.messages()[0];
}

TEST(AnyLayout, ACameraWithoutAPoseIsTakenAndThatIsSaid) {
  const EurocFolder f;
  f.replace("cam0/sensor.yaml", "T_BS:", "unused:");
  EurocOptions o;
  o.source = f.root().string();
  ProblemLog log;
  const Recording recording(o, &log);
  const CameraYaml& c = recording.cameras()[0].calibration;
  EXPECT_FALSE(c.has_pose);
  EXPECT_EQ(c.T_B_C.p.norm(), 0);
  EXPECT_EQ(c.T_B_C.q.w(), 1);
  EXPECT_EQ(c.camera.fx, 40.5);
  EXPECT_TRUE(contains(log.messages().at(0), "its pose on the IMU is not given"))
      << log.messages()[0];
}

TEST(AnyLayout, ACalibrationFromElsewhereGoesBefore) {
  const EurocFolder f;
  std::filesystem::remove(f.mav0() / "cam0/sensor.yaml");
  f.write("given.yaml",
          "cam0:\n  T_cam_imu: [[0,-1,0,0],[0,0,-1,0],[1,0,0,-0.5],[0,0,0,1]]\n"
          "  camera_model: pinhole\n  intrinsics: [41, 42, 31, 25]\n  resolution: [64, 48]\n"
          "  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n"
          "  timeshift_cam_imu: 0.004\n");
  EurocOptions o;
  o.source = f.root().string();
  ProblemLog none;
  EXPECT_THROW(Recording(o, &none), InputError);
  o.calibration = (f.mav0() / "given.yaml").string();
  ProblemLog log;
  const Recording recording(o, &log);
  EXPECT_EQ(recording.cameras()[0].calibration.camera.fx, 41);
  EXPECT_LT((recording.cameras()[0].calibration.T_B_C.p - Vec3(0.5, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(recording.cameras()[0].time_offset_s, 0.004);
  EXPECT_TRUE(recording.imu().has_noise);  // still the recording's own
  EXPECT_TRUE(contains(log.messages().at(0), "intrinsics, its pose on the IMU, its time offset"))
      << log.messages()[0];
}

}  // namespace
}  // namespace vir::euroc
