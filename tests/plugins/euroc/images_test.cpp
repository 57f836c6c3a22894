#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "image_head.h"
#include "image_store.h"
#include "input_error.h"
#include "vir_test_euroc_folder.h"

namespace vir::euroc {
namespace {

/// A head that claims what the bytes behind it cannot hold is not believed: decoders make room
/// first.
TEST(ImageHead, ClaimsOfPixels) {
  const cv::Mat small(48, 64, CV_8UC1, cv::Scalar(7));
  for (const char* kind : {".png", ".jpg", ".bmp", ".tif"}) {
    std::vector<unsigned char> bytes;
    cv::imencode(kind, small, bytes);
    EXPECT_TRUE(pixelsFit(bytes.data(), bytes.size())) << kind;
    for (std::size_t n = 0; n < bytes.size(); ++n) {
      const std::vector<unsigned char> cut(bytes.begin(), bytes.begin() + static_cast<long>(n));
      pixelsFit(cut.data(), cut.size());  // reads nothing beyond the end
    }
    int refused = 0;
    for (std::size_t at = 0; at + 4 <= bytes.size(); ++at) {
      std::vector<unsigned char> lie = bytes;
      // A TIFF has width and height 12 bytes apart, others beside each other.
      for (const std::size_t from : {at, at + 12}) {
        for (std::size_t i = from; i < std::min(from + 4, lie.size()); ++i) {
          lie[i] = (i - from) % 2 == 0 ? 0x7F : 0xFF;
        }
        if (std::string(kind) != ".tif") break;
      }
      if (!pixelsFit(lie.data(), lie.size())) ++refused;
    }
    EXPECT_GT(refused, 0) << kind;
  }
  // A black image of 24 megapixels packs a thousandfold, and is one.
  std::vector<unsigned char> black;
  cv::imencode(".png", cv::Mat(4000, 6000, CV_8UC1, cv::Scalar(0)), black);
  EXPECT_TRUE(pixelsFit(black.data(), black.size())) << black.size();
}

namespace fs = std::filesystem;

struct Fixture {
  explicit Fixture(const test::EurocFolderOptions& o = {}) : folder(o) {}
  ImageStore store(ImageMode mode) {
    return ImageStore(mode, target().string(), "CAM0", 64, 48, &log);
  }
  fs::path target() const { return folder.temp() / "x_Images"; }
  test::EurocFolder folder;
  ProblemLog log;
  StoredImage out;
};

TEST(ImageStore, LinksUnderTheStampsName) {
  Fixture f;
  ImageStore s = f.store(ImageMode::link);
  ASSERT_TRUE(s.store(42, f.folder.imageFile(0).string(), "list:1", &f.out));
  EXPECT_EQ(f.out.external_name, "CAM0_42.png");
  EXPECT_TRUE(fs::is_symlink(f.target() / "CAM0_42.png"));
  EXPECT_TRUE(fs::equivalent(f.target() / "CAM0_42.png", f.folder.imageFile(0)));
}

TEST(ImageStore, CopiesByteByByte) {
  Fixture f;
  ImageStore s = f.store(ImageMode::copy);
  ASSERT_TRUE(s.store(42, f.folder.imageFile(0).string(), "list:1", &f.out));
  EXPECT_FALSE(fs::is_symlink(f.target() / "CAM0_42.png"));
  EXPECT_EQ(test::readText(f.target() / "CAM0_42.png"), test::readText(f.folder.imageFile(0)));
}

TEST(ImageStore, EmbedsPixels) {
  Fixture f;
  ImageStore s = f.store(ImageMode::embed);
  ASSERT_TRUE(s.store(42, f.folder.imageFile(3).string(), "list:1", &f.out));
  EXPECT_TRUE(f.out.external_name.empty());
  EXPECT_EQ(f.out.pixels.at<std::uint8_t>(7, 20), 10 + 3 + 20);
  EXPECT_FALSE(fs::exists(f.target()));
}

TEST(ImageStore, SixteenBitImagesBecomeEightBit) {
  test::EurocFolderOptions o;
  o.tum_vi = true;
  Fixture f(o);
  ImageStore s = f.store(ImageMode::link);
  ASSERT_TRUE(s.store(42, f.folder.imageFile(3).string(), "list:1", &f.out));
  const cv::Mat m = cv::imread((f.target() / f.out.external_name).string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(m.type(), CV_8UC1);
  EXPECT_EQ(m.at<std::uint8_t>(7, 20), 10 + 3 + 20);
  EXPECT_FALSE(fs::is_symlink(f.target() / f.out.external_name));
  EXPECT_EQ(f.log.get("images_converted_16_to_8_bit"), 1);
}

TEST(ImageStore, MissingEmptyCutAndGarbageFilesAreSkipped) {
  Fixture f;
  ImageStore s = f.store(ImageMode::link);
  const std::string whole = test::readText(f.folder.imageFile(1));
  test::writeText(f.folder.imageFile(1), "");
  test::writeText(f.folder.imageFile(2), whole.substr(0, whole.size() / 2));
  test::writeText(f.folder.imageFile(3), "this is not an image");
  std::string flipped = whole;
  flipped[whole.size() / 2] = static_cast<char>(flipped[whole.size() / 2] ^ 0x55);
  test::writeText(f.folder.imageFile(4), flipped);
  for (const int i : {1, 2, 3, 4}) {
    EXPECT_FALSE(s.store(i, f.folder.imageFile(i).string(), "list:7", &f.out)) << i;
  }
  EXPECT_EQ(f.log.get("image_undecodable"), 4);
  EXPECT_FALSE(s.store(5, "/nonexistent.png", "list:8", &f.out));
  EXPECT_FALSE(s.store(6, f.folder.mav0().string(), "list:9", &f.out));  // a folder
  EXPECT_EQ(f.log.get("image_missing"), 2);
  EXPECT_NE(f.log.first("image_undecodable").find("list:7"), std::string::npos);
  EXPECT_FALSE(fs::exists(f.target()));
}

TEST(ImageStore, ACutJpegIsNotMistakenForAnImage) {
  Fixture f;
  ImageStore s = f.store(ImageMode::embed);
  const fs::path file = f.folder.temp() / "a.jpg";
  cv::Mat noise(48, 64, CV_8UC1);
  cv::randu(noise, 0, 255);
  cv::imwrite(file.string(), noise);
  EXPECT_TRUE(s.store(1, file.string(), "list:1", &f.out));
  const std::string whole = test::readText(file);
  test::writeText(file, whole.substr(0, whole.size() * 2 / 3));
  EXPECT_FALSE(s.store(2, file.string(), "list:2", &f.out));
  EXPECT_EQ(f.log.get("image_undecodable"), 1);
}

TEST(ImageStore, AnotherSizeThanTheCalibrationIsRefused) {
  Fixture f;
  ImageStore s(ImageMode::embed, "", "CAM0", 65, 48, &f.log);
  EXPECT_FALSE(s.store(1, f.folder.imageFile(0).string(), "list:1", &f.out));
  EXPECT_EQ(f.log.get("image_wrong_size"), 1);
  EXPECT_NE(f.log.messages()[0].find("64x48 pixels, the calibration 65x48"), std::string::npos);
}

TEST(ImageStore, AFolderThatCannotBeWrittenIsAnError) {
  Fixture f;
  test::writeText(f.folder.temp() / "file", "x");
  ImageStore s(ImageMode::copy, (f.folder.temp() / "file" / "sub").string(), "CAM0", 64, 48,
               &f.log);
  EXPECT_THROW(s.store(1, f.folder.imageFile(0).string(), "list:1", &f.out), InputError);
}

}  // namespace
}  // namespace vir::euroc
