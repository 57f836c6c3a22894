/// What is drawn is where the camera model says, and nothing is seen through anything.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "made_scenes.h"
#include "vir/rendering/scene_renderer.h"

namespace {

using namespace vir;
using vir_test::calibration;
using vir_test::lookingAhead;
using vir_test::rendered;

const Distortion kModels[] = {Distortion::none, Distortion::radtan, Distortion::equidistant};

/// Where a dark-bright edge crosses row y near x0, from the grey levels of the pixels it covers
/// partly: the area left of the edge [px]. Both sides may change linearly.
double edgeAt(const vir::rendering::FloatImage& image, int x0, int y) {
  constexpr int kReach = 5;
  const auto slope = [&](int x, int step) {
    return (image.at(x + step, y) - image.at(x, y)) / static_cast<double>(step);
  };
  const double left_slope = slope(x0 - kReach, 2), right_slope = slope(x0 + kReach, -2);
  double area = 0;
  for (int x = x0 - kReach + 1; x < x0 + kReach; ++x) {
    const double left = image.at(x0 - kReach, y) + left_slope * (x - x0 + kReach);
    const double right = image.at(x0 + kReach, y) + right_slope * (x - x0 - kReach);
    area += (image.at(x, y) - right) / (left - right);
  }
  return x0 - kReach + 0.5 + area;
}

TEST(SceneRenderer, DrawsEdgesWhereTheyProject) {
  for (const Distortion kind : kModels) {
    const auto camera = camera::makeCamera(calibration(kind));
    vir::rendering::SceneRenderer renderer(vir_test::twoCrates(), camera, 1);
    int checked = 0;
    double square = 0;
    for (int view = 0; view < 12; ++view) {
      const Pose T_W_C = lookingAhead(Vec3(0.07 * view, 0.07 * view - 0.4, 0.03 * view),
                                      Vec3(0.01 * view, 0.013 * view - 0.1, 0.004 * view));
      const vir::rendering::FloatImage image = rendered(&renderer, T_W_C, 0);
      // Points along both upright front edges of the near crate.
      for (const double y : {-0.5, 0.45}) {
        for (double z = -0.4; z < 0.45; z += 0.05) {
          Vec2 px, above;
          const Pose T_C_W = T_W_C.inverse();
          if (!camera->project(T_C_W * Vec3(3, y, z), &px)) continue;
          if (!camera->project(T_C_W * Vec3(3, y, z + 0.01), &above)) continue;
          // Onto the centre of the nearest row, along the edge.
          const int row = static_cast<int>(std::lround(px.y()));
          const double x = px.x() + (row - px.y()) * (above.x() - px.x()) / (above.y() - px.y());
          const int near = static_cast<int>(std::lround(x));
          if (near < 8 || near > 367 || row < 0 || row > 239) continue;
          // Only where nothing else is near (the crates' sides do not show from here).
          const double contrast = std::abs(image.at(near - 5, row) - image.at(near + 5, row));
          const double left = std::abs(image.at(near - 5, row) - image.at(near - 3, row));
          const double right = std::abs(image.at(near + 5, row) - image.at(near + 3, row));
          if (contrast < 10 || std::max(left, right) > 0.03 * contrast) continue;
          const double error = edgeAt(image, near, row) - x;
          EXPECT_LT(std::abs(error), 0.1) << "view " << view << " row " << row;
          square += error * error;
          ++checked;
        }
      }
    }
    EXPECT_GT(checked, 150);
    EXPECT_LT(std::sqrt(square / checked), 0.04);
  }
}

/// Distance along a ray of W to the first surface of the scene, by brute force.
double firstHit(const vir::rendering::Scene& scene, const Vec3& eye, const Vec3& ray) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double wall = ray[k] > 0 ? scene.interior().high[k] : scene.interior().low[k];
    nearest = std::min(nearest, (wall - eye[k]) / ray[k]);
  }
  for (const vir::rendering::Box& b : scene.boxes()) {
    for (int k = 0; k < 3; ++k) {
      for (const double side : {b.low[k], b.high[k]}) {
        const double t = (side - eye[k]) / ray[k];
        Vec3 p = eye + t * ray;
        p[k] = side;
        if (t > 0 && b.holds(p, 1e-9)) nearest = std::min(nearest, t);
      }
    }
  }
  return nearest;
}

double interpolated(const vir::rendering::FloatImage& image, const Vec2& px) {
  const int x = static_cast<int>(std::floor(px.x())), y = static_cast<int>(std::floor(px.y()));
  const double a = px.x() - x, b = px.y() - y;
  return (1 - b) * ((1 - a) * image.at(x, y) + a * image.at(x + 1, y)) +
         b * ((1 - a) * image.at(x, y + 1) + a * image.at(x + 1, y + 1));
}

struct Alignment {
  bool usable = false;
  Vec2 shift = Vec2::Zero();  ///< how far the texture is from where it should be [px]
  double similarity = 0;      ///< normalised cross-correlation
};

/// Carries a patch of image 0 over to image 1 by the true geometry, pixel by pixel, and measures by
/// how much it is off there.
Alignment align(const vir::rendering::Scene& scene, const camera::CameraModel& camera,
                const Pose& T_W_C0, const vir::rendering::FloatImage& image0, const Pose& T_W_C1,
                const vir::rendering::FloatImage& image1, const Vec2& centre) {
  constexpr int kHalf = 8, kRim = 3;
  Alignment out;
  Eigen::Matrix2d H = Eigen::Matrix2d::Zero();
  Vec2 b = Vec2::Zero();
  double s0 = 0, s1 = 0, s00 = 0, s11 = 0, s01 = 0, n = 0, depth = 0;
  for (int dy = -kHalf - kRim; dy <= kHalf + kRim; ++dy) {
    for (int dx = -kHalf - kRim; dx <= kHalf + kRim; ++dx) {
      const Vec2 px0 = centre + Vec2(dx, dy);
      Vec3 bearing;
      Vec2 px1;
      if (!camera.unproject(px0, &bearing)) return out;
      const Vec3 ray = T_W_C0.q * bearing;
      const double t = firstHit(scene, T_W_C0.p, ray);
      // An edge crosses the patch, or comes near.
      if (depth > 0 && std::abs(t - depth) > 0.15 * depth) return out;
      depth = t;
      const Vec3 p_W = T_W_C0.p + t * ray;
      if (scene.hidden(T_W_C1.p, T_W_C1.p + 0.999 * (p_W - T_W_C1.p))) return out;
      if (!camera.project(T_W_C1.inverse() * p_W, &px1)) return out;
      if (px1.x() < 2 || px1.y() < 2 || px1.x() > 372 || px1.y() > 236) return out;
      if (std::max(std::abs(dx), std::abs(dy)) > kHalf) continue;
      const double v0 = interpolated(image0, px0), v1 = interpolated(image1, px1);
      const Vec2 g(
          0.5 * (interpolated(image1, px1 + Vec2(1, 0)) - interpolated(image1, px1 - Vec2(1, 0))),
          0.5 * (interpolated(image1, px1 + Vec2(0, 1)) - interpolated(image1, px1 - Vec2(0, 1))));
      H += g * g.transpose();
      b += g * (v0 - v1);
      s0 += v0, s1 += v1, s00 += v0 * v0, s11 += v1 * v1, s01 += v0 * v1, n += 1;
    }
  }
  const double spread = std::sqrt((s00 - s0 * s0 / n) * (s11 - s1 * s1 / n));
  // A corner, as a tracker would choose it.
  if (H.selfadjointView<Eigen::Lower>().eigenvalues()[0] < 1.5e4 || spread < 100) return out;
  out.usable = true;
  out.shift = H.ldlt().solve(b);
  out.similarity = (s01 - s0 * s1 / n) / spread;
  return out;
}

TEST(SceneRenderer, TexturesStayOnTheirSurfaces) {
  const auto scene = vir_test::twoCrates();
  for (const Distortion kind : kModels) {
    const auto camera = camera::makeCamera(calibration(kind));
    vir::rendering::SceneRenderer renderer(scene, camera, 1);
    const Pose T_W_C0 = lookingAhead(Vec3(0.2, 0.1, 0.1), Vec3(0.05, -0.03, 0.02));
    const vir::rendering::FloatImage image0 = rendered(&renderer, T_W_C0);
    int checked = 0;
    double square = 0;
    Vec2 mean = Vec2::Zero();
    for (int view = 0; view < 6; ++view) {
      // Up to a quarter of a metre and some degrees to the side.
      const Pose T_W_C1 = lookingAhead(Vec3(0.2 + 0.03 * view, 0.1 - 0.04 * view, 0.1),
                                       Vec3(0.05 - 0.006 * view, -0.03 + 0.004 * view, 0.02));
      const vir::rendering::FloatImage image1 = rendered(&renderer, T_W_C1);
      for (int y = 16; y < 224; y += 12) {
        for (int x = 16; x < 360; x += 12) {
          const Alignment a = align(*scene, *camera, T_W_C0, image0, T_W_C1, image1, Vec2(x, y));
          if (!a.usable) continue;
          EXPECT_LT(a.shift.norm(), 0.2) << "at " << x << " " << y << " view " << view;
          EXPECT_GT(a.similarity, 0.9);
          square += a.shift.squaredNorm();
          mean += a.shift;
          ++checked;
        }
      }
    }
    EXPECT_GT(checked, 150);
    EXPECT_LT(std::sqrt(square / checked), 0.05);
    EXPECT_LT((mean / checked).norm(), 0.01);
  }
}

TEST(SceneRenderer, WhatIsHiddenChangesNothing) {
  const auto camera = camera::makeCamera(calibration(Distortion::radtan));
  std::vector<vir::rendering::Box> boxes = vir_test::crates();
  // Behind the near crate as seen from the origin; the same number of boxes, so the same surfaces.
  boxes.push_back({Vec3(4.5, -0.2, -0.2), Vec3(4.8, 0.2, 0.2)});
  vir::rendering::SceneRenderer with(
      std::make_shared<vir::rendering::Scene>(vir_test::room(), boxes), camera, 1);
  boxes.back() = {Vec3(4.6, -0.1, -0.1), Vec3(4.7, 0.1, 0.1)};
  vir::rendering::SceneRenderer other(
      std::make_shared<vir::rendering::Scene>(vir_test::room(), boxes), camera, 1);
  const Pose ahead = lookingAhead(Vec3::Zero());
  EXPECT_EQ(rendered(&with, ahead).pixels, rendered(&other, ahead).pixels);
  // From above both show.
  const Pose above = lookingAhead(Vec3(0, 0, 2), Vec3(-0.4, 0, 0));
  EXPECT_NE(rendered(&with, above).pixels, rendered(&other, above).pixels);
}

/// How alike the middle of two images is: their normalised cross-correlation.
double likeness(const vir::rendering::FloatImage& a, const vir::rendering::FloatImage& b) {
  double n = 0, sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for (int y = 90; y < 160; ++y) {
    for (int x = 155; x < 215; ++x) {
      const double u = a.at(x, y), v = b.at(x, y);
      n += 1, sa += u, sb += v, saa += u * u, sbb += v * v, sab += u * v;
    }
  }
  return (sab - sa * sb / n) / std::sqrt((saa - sa * sa / n) * (sbb - sb * sb / n));
}

TEST(SceneRenderer, BoxesOfOneLookArePaintedAlike) {
  const auto camera = camera::makeCamera(calibration(Distortion::radtan));
  const Vec3 apart(2, 2.2, 0.3);
  const auto twins = [&](int first, int second) {
    std::vector<vir::rendering::Box> boxes(2, vir_test::crates().front());
    boxes[1].low += apart;
    boxes[1].high += apart;
    boxes[0].look = first;
    boxes[1].look = second;
    vir::rendering::SceneRenderer renderer(
        std::make_shared<vir::rendering::Scene>(vir_test::room(), boxes), camera, 1);
    return likeness(rendered(&renderer, lookingAhead(Vec3::Zero())),
                    rendered(&renderer, lookingAhead(apart)));
  };
  EXPECT_GT(twins(3, 3), 0.99);
  EXPECT_LT(twins(3, 4), 0.5);
  EXPECT_LT(twins(-1, -1), 0.5);
}

TEST(SceneRenderer, NearHidesFar) {
  const auto camera = camera::makeCamera(calibration(Distortion::none));
  vir::rendering::SceneRenderer renderer(vir_test::twoCrates(), camera, 1);
  // Plain faces: every pixel of the near crate's front has nearly the same grey level, which is not
  // that of the wall behind it.
  const vir::rendering::FloatImage image = rendered(&renderer, lookingAhead(Vec3::Zero()), 0);
  vir::rendering::SceneRenderer empty(
      std::make_shared<vir::rendering::Scene>(vir_test::room(), std::vector<vir::rendering::Box>()),
      camera, 1);
  const vir::rendering::FloatImage wall = rendered(&empty, lookingAhead(Vec3::Zero()), 0);
  const float centre = image.at(184, 124);
  EXPECT_GT(std::abs(centre - wall.at(184, 124)), 3);
  for (int y = 90; y < 160; y += 5) {
    for (int x = 155; x < 215; x += 5) EXPECT_NEAR(image.at(x, y), centre, 0.05 * centre);
  }
}

TEST(SceneRenderer, IsRepeatableAndAddsUp) {
  const auto camera = camera::makeCamera(calibration(Distortion::equidistant));
  vir::rendering::SceneRenderer a(vir_test::twoCrates(), camera, 3),
      b(vir_test::twoCrates(), camera, 3);
  vir::rendering::SceneRenderer c(vir_test::twoCrates(), camera, 4);
  const Pose T = lookingAhead(Vec3(0.3, 0.2, 0));
  rendered(&a, lookingAhead(Vec3::Zero()));  // what was drawn before does not matter
  const vir::rendering::FloatImage once = rendered(&a, T);
  EXPECT_EQ(once.pixels, rendered(&b, T).pixels);
  EXPECT_NE(once.pixels, rendered(&c, T).pixels);
  vir::rendering::FloatImage twice;
  a.add(T, 1, 0.5F, &twice);
  a.add(T, 1, 0.25F, &twice);
  for (std::size_t k = 0; k < once.pixels.size(); k += 97) {
    EXPECT_NEAR(twice.pixels[k], 0.75 * once.pixels[k], 1e-3);
  }
}

TEST(SceneRenderer, IsTheSameWithAndWithoutWideVectors) {
  for (const Distortion kind : kModels) {
    const auto camera = camera::makeCamera(calibration(kind));
    vir::rendering::SceneRenderer wide(vir_test::twoCrates(), camera, 3),
        narrow(vir_test::twoCrates(), camera, 3);
    narrow.useNarrowVectors();
    for (int view = 0; view < 4; ++view) {
      const Pose T = lookingAhead(Vec3(0.2 * view, 0.3 - 0.2 * view, 0.05 * view),
                                  Vec3(0.1 * view, 0.05 * view, -0.1 * view));
      EXPECT_EQ(rendered(&wide, T).pixels, rendered(&narrow, T).pixels) << "view " << view;
    }
  }
}

TEST(SceneRenderer, SeesBlackFromOutsideTheRoom) {
  const auto camera = camera::makeCamera(calibration(Distortion::none));
  vir::rendering::SceneRenderer renderer(vir_test::twoCrates(), camera, 1);
  for (const float grey : rendered(&renderer, lookingAhead(Vec3(-5, 0, 0))).pixels) {
    ASSERT_EQ(grey, 0);
  }
}

TEST(SceneRenderer, TextureIsEverywhere) {
  const auto camera = camera::makeCamera(calibration(Distortion::radtan));
  vir::rendering::SceneRenderer renderer(vir_test::twoCrates(), camera, 1);
  const vir::rendering::FloatImage image = rendered(&renderer, lookingAhead(Vec3::Zero()));
  // The spread of grey levels within squares of 40 pixels.
  int plain = 0, squares = 0;
  for (int y = 0; y + 40 <= image.height; y += 40) {
    for (int x = 0; x + 40 <= image.width; x += 40) {
      double sum = 0, square = 0;
      for (int k = 0; k < 1600; ++k) {
        const double v = image.at(x + k % 40, y + k / 40);
        sum += v;
        square += v * v;
      }
      const double spread = std::sqrt(square / 1600 - std::pow(sum / 1600, 2));
      plain += spread < 3 ? 1 : 0;
      ++squares;
    }
  }
  EXPECT_LT(plain, squares / 4);
}

TEST(SceneRenderer, NeedsSceneAndCamera) {
  const auto camera = camera::makeCamera(calibration(Distortion::none));
  EXPECT_THROW(vir::rendering::SceneRenderer(nullptr, camera, 1), std::invalid_argument);
  EXPECT_THROW(vir::rendering::SceneRenderer(vir_test::twoCrates(), nullptr, 1),
               std::invalid_argument);
}

}  // namespace
