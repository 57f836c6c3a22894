#include "vir/rawlog/mrpt_camera.h"

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationImage.h>

#include "vir/rawlog/rawlog_reader.h"
#include "vir/rawlog/rawlog_writer.h"
#include "vir_test_temp_folder.h"

namespace vir::rawlog {
namespace {

CameraCalibration camera(Distortion kind, std::array<double, 8> dist) {
  CameraCalibration c;
  c.width = 752;
  c.height = 480;
  c.fx = 458.654, c.fy = 457.296, c.cx = 367.215, c.cy = 248.375;
  c.distortion = kind;
  c.dist = dist;
  return c;
}

/// Through a file, since MRPT need not write all that it holds.
TEST(MrptCamera, EveryModelSurvivesARawlog) {
  const std::vector<CameraCalibration> cameras{
      camera(Distortion::none, {}),
      camera(Distortion::radtan, {-0.28, 0.07, 2e-4, 1.7e-5, 0.01}),
      camera(Distortion::equidistant, {0.1, 0.2, 0.3, 0.4}),
      camera(Distortion::rational, {10.2, -120.5, 3e-4, -5e-4, 430.1, 10.0, -119.1, 426.0}),
      camera(Distortion::double_sphere, {-0.2, 0.59}),
      camera(Distortion::omni, {1.6, -0.1, 0.02, 0.001, -0.002})};
  const test::TempFolder folder;
  const std::string file = (folder / "c.rawlog").string();
  RawlogWriter writer(file);
  for (const CameraCalibration& c : cameras) {
    mrpt::obs::CObservationImage image;
    image.cameraParams = toMrptCamera(c, "left eye");
    writer.write(image);
  }
  writer.finish();
  RawlogReader reader(file);
  for (const CameraCalibration& c : cameras) {
    const auto o = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(reader.next());
    ASSERT_NE(o, nullptr);
    const CameraCalibration back = fromMrptCamera(o->cameraParams);
    EXPECT_EQ(back.distortion, c.distortion);
    EXPECT_EQ(back.dist, c.dist);
    EXPECT_EQ(back.width, c.width);
    EXPECT_EQ(back.height, c.height);
    EXPECT_EQ(Eigen::Vector4d(back.fx, back.fy, back.cx, back.cy),
              Eigen::Vector4d(c.fx, c.fy, c.cx, c.cy));
    EXPECT_EQ(nameOf(o->cameraParams), "left eye");
  }
}

}  // namespace
}  // namespace vir::rawlog
