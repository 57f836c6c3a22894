#include "vir/formats/lens_names.h"

#include <gtest/gtest.h>

#include <fstream>

#include "vir/formats/calibration_file.h"
#include "vir_test_temp_folder.h"

namespace vir::formats {
namespace {

std::string listed(const std::vector<double>& numbers) {
  std::string out;
  for (const double v : numbers) out += (out.empty() ? "" : ", ") + std::to_string(v);
  return "[" + out + "]";
}

/// What is written is what the reader takes.
TEST(LensNames, ComeBackAsTheyWere) {
  const test::TempFolder folder;
  for (const Distortion model :
       {Distortion::none, Distortion::radtan, Distortion::rational, Distortion::equidistant,
        Distortion::omni, Distortion::double_sphere}) {
    CameraCalibration c;
    c.width = 640, c.height = 480;
    c.fx = 400, c.fy = 401, c.cx = 320, c.cy = 240;
    c.distortion = model;
    const std::size_t used[] = {0, 5, 4, 8, 2, 5};  // in the order of the enumeration
    for (std::size_t i = 0; i < used[static_cast<std::size_t>(model)]; ++i) {
      c.dist[i] = 0.125 / static_cast<double>(i + 1);
    }
    ListedLens lens = listedLens(c);
    lens.before_focal.insert(lens.before_focal.end(), {c.fx, c.fy, c.cx, c.cy});
    const std::string path = (folder / "camchain.yaml").string();
    std::ofstream(path) << "cam0:\n  camera_model: " << lens.camera_model
                        << "\n  intrinsics: " << listed(lens.before_focal)
                        << "\n  distortion_model: " << lens.distortion_model
                        << "\n  distortion_coeffs: " << listed(lens.coefficients)
                        << "\n  resolution: [640, 480]\n";
    const CameraCalibration back = readCalibrationFile(path).cameras.at(0).camera;
    EXPECT_EQ(back.distortion, model);
    EXPECT_EQ(back.fx, c.fx);
    EXPECT_EQ(back.cy, c.cy);
    for (std::size_t i = 0; i < c.dist.size(); ++i) {
      EXPECT_NEAR(back.dist[i], c.dist[i], 1e-6) << static_cast<int>(model) << ", " << i;
    }
  }
}

}  // namespace
}  // namespace vir::formats
