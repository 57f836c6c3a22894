/// A file in, observations in time order out, with what a camera's image brings along.
#include "vir/rawlog/ordered_reader.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "vir/rawlog/convert.h"
#include "vir/rawlog/gray_image.h"
#include "vir_test_rawlog.h"
#include "vir_test_temp_folder.h"

namespace vir::rawlog {
namespace {

using test::imageAt;
using test::imuAt;
using test::kMs;
using test::kStart;
using test::TempFolder;

TEST(OrderedReader, BurstsComeOutInOrderToTheLast) {
  const TempFolder folder;
  const std::string path = (folder / "a.rawlog").string();
  RawlogWriter writer(path);
  for (int i = 0; i < 10; ++i) writer.write(*imuAt(kStart + i * 5 * kMs));
  for (int i = 0; i < 3; ++i) writer.write(*imageAt(kStart + i * 20 * kMs + kMs));
  writer.finish();

  OrderedReader reader(path);
  TimeNs before = 0;
  int count = 0;
  while (const auto o = reader.next()) {
    const TimeNs t = fromMrptTime(o->timestamp);
    EXPECT_GT(t, before);
    before = t;
    ++count;
  }
  EXPECT_EQ(count, 13);
  EXPECT_EQ(reader.next(), nullptr);
  EXPECT_EQ(reader.reader().objects(), 13u);
  EXPECT_EQ(reader.reader().progress(), 1.0);
  EXPECT_TRUE(reader.orderer().counters().empty());
}

TEST(OrderedReader, TheCameraComesWithTheFirstImageOfItsLabel) {
  const TempFolder folder;
  const std::string path = (folder / "a.rawlog").string();
  RawlogWriter writer(path);
  for (const auto& [label, fx] : {std::pair("CAM1", 300.0), std::pair("CAM0", 400.0)}) {
    const auto image = imageAt(kStart);
    image->sensorLabel = label;
    image->cameraParams.fx(fx);
    image->cameraPose.setFromValues(0.1, 0.2, 0.3);
    writer.write(*image);
  }
  writer.finish();

  const Calibration found = calibrationIn(path, "CAM0");
  EXPECT_EQ(found.camera.fx, 400.0);
  EXPECT_TRUE(found.T_B_C.p.isApprox(Vec3(0.1, 0.2, 0.3), 1e-12));
  EXPECT_THROW(calibrationIn(path, "CAM2"), std::runtime_error);
  EXPECT_FALSE(calibrationOf(*imuAt(kStart)));
}

TEST(GrayImage, SharesGrayPixelsAndConvertsColour) {
  const auto gray = imageAt(kStart, 77);
  const auto shared = grayImageOf(*gray);
  ASSERT_TRUE(shared);
  EXPECT_EQ(shared->view().t, kStart);
  EXPECT_EQ(shared->view().pixels, gray->image.ptrLine<std::uint8_t>(0));
  EXPECT_EQ(shared->view().width, static_cast<int>(gray->image.getWidth()));
  EXPECT_EQ(shared->view().height, static_cast<int>(gray->image.getHeight()));
  EXPECT_EQ(shared->view().stride, gray->image.getRowStride());

  const auto colour = imageAt(kStart, 77);
  colour->image = gray->image.colorImage();
  const auto converted = grayImageOf(*colour);
  ASSERT_TRUE(converted);
  EXPECT_EQ(converted->pixels.channels(), 1);
  EXPECT_EQ(converted->view().pixels[0], 77);
  EXPECT_FALSE(grayImageOf(*imuAt(kStart)));
}

}  // namespace
}  // namespace vir::rawlog
