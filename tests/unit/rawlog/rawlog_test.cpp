/// Writing and reading rawlogs that are as they should be.
#include <gtest/gtest.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/serialization/CArchive.h>

#include "vir/rawlog/rawlog_reader.h"
#include "vir_test_rawlog.h"
#include "vir_test_temp_folder.h"

namespace vir::rawlog {
namespace {

namespace fs = std::filesystem;
using test::imageAt;
using test::imuAt;
using test::kMs;
using test::kStart;
using test::TempFolder;

TEST(Rawlog, WhatIsWrittenComesBack) {
  for (const int compression : {0, 1, 9}) {
    const TempFolder folder;
    const std::string path = (folder / "a.rawlog").string();
    RawlogWriter writer(path, compression);
    writer.write(*imuAt(kStart));
    writer.write(*imageAt(kStart + kMs, 77));
    EXPECT_FALSE(fs::exists(path));  // only under its name when complete
    writer.finish();
    EXPECT_TRUE(fs::exists(path));
    EXPECT_FALSE(fs::exists(path + ".part"));

    RawlogReader reader(path);
    const auto imu = std::dynamic_pointer_cast<mrpt::obs::CObservationIMU>(reader.next());
    ASSERT_TRUE(imu);
    EXPECT_EQ(imu->get(mrpt::obs::IMU_Z_ACC), 9.81);
    EXPECT_EQ(fromMrptTime(imu->timestamp), kStart);
    const auto image = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(reader.next());
    ASSERT_TRUE(image);
    EXPECT_EQ(image->image.at<std::uint8_t>(0, 0), 77);
    EXPECT_EQ(reader.next(), nullptr);
    EXPECT_EQ(reader.next(), nullptr);
    EXPECT_EQ(reader.damage(), "");
    EXPECT_EQ(reader.objects(), 2u);
    EXPECT_EQ(reader.progress(), 1.0);
  }
}

TEST(Rawlog, AnAbandonedWriterLeavesNothing) {
  const TempFolder folder;
  { RawlogWriter((folder / "a.rawlog").string()).write(*imuAt(kStart)); }
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(Rawlog, WriterMakesTheFolder) {
  const TempFolder folder;
  RawlogWriter writer((folder / "deep/er/a.rawlog").string());
  writer.finish();
  EXPECT_TRUE(fs::exists(folder / "deep/er/a.rawlog"));
}

TEST(Rawlog, ImageFolderName) {
  EXPECT_EQ(RawlogWriter::imageFolderOf("x/a.rawlog"), "x/a_Images");
  EXPECT_EQ(RawlogWriter::imageFolderOf("x/a.rawlog.gz"), "x/a_Images");
  EXPECT_EQ(RawlogWriter::imageFolderOf("a.b"), "a.b_Images");
}

/// Two recordings with image folders of their own in one process.
TEST(Rawlog, ExternalImagesOfTwoRecordings) {
  const TempFolder folder;
  for (const int i : {1, 2}) {
    const std::string path = (folder / ("r" + std::to_string(i) + ".rawlog")).string();
    const std::string images = RawlogWriter::imageFolderOf(path);
    fs::create_directories(images);
    auto image = imageAt(kStart, 10 * i);
    ASSERT_TRUE(image->image.saveToFile(images + "/one.png"));
    image->image.setExternalStorage("one.png");
    RawlogWriter writer(path);
    writer.write(*image);
    writer.finish();
  }
  RawlogReader first((folder / "r1.rawlog").string());
  RawlogReader second((folder / "r2.rawlog").string());
  const auto one = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(first.next());
  const auto two = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(second.next());
  one->load();
  two->load();
  EXPECT_EQ(one->image.at<std::uint8_t>(0, 0), 10);
  EXPECT_EQ(two->image.at<std::uint8_t>(0, 0), 20);
}

TEST(Rawlog, MembersOfSensoryFramesAndForeignObjects) {
  const TempFolder folder;
  const std::string path = (folder / "a.rawlog").string();
  {
    mrpt::io::CFileGZOutputStream file;
    ASSERT_TRUE(file.open(path));
    auto archive = mrpt::serialization::archiveFrom(file);
    mrpt::obs::CSensoryFrame frame;
    frame.insert(imuAt(kStart));
    frame.insert(imageAt(kStart));
    archive << frame << mrpt::poses::CPose3D() << *imuAt(kStart + kMs);
  }
  RawlogReader reader(path);
  int observations = 0;
  while (reader.next()) ++observations;
  EXPECT_EQ(observations, 3);
  EXPECT_EQ(reader.objects(), 3u);
  EXPECT_EQ(reader.skipped(), 1u);
  EXPECT_EQ(reader.damage(), "");
}

TEST(Rawlog, ConcatenatedFilesAreOne) {
  const TempFolder folder;
  test::writeRecording((folder / "a.rawlog").string(), 2);
  const std::string text = test::readText(folder / "a.rawlog");
  test::writeText(folder / "b.rawlog", text + text);
  RawlogReader reader((folder / "b.rawlog").string());
  int observations = 0;
  while (reader.next()) ++observations;
  EXPECT_EQ(observations, 2 * 24);
  EXPECT_EQ(reader.damage(), "");
}

}  // namespace
}  // namespace vir::rawlog
