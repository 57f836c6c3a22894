#include "vir/evaluation/figure.h"

#include <gtest/gtest.h>

#include <cmath>

#include "made_trajectories.h"
#include "vir/evaluation/figure_parts.h"

namespace vir::evaluation {
namespace {

TEST(AxisTicks, RoundSteps) {
  EXPECT_EQ(axisTicks(0, 10, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  const std::vector<double> t = axisTicks(-0.034, 0.031, 6);
  ASSERT_EQ(t.size(), 7u);  // 0.065 / 6 is nearer to 0.01 than to 0.02
  EXPECT_NEAR(t[0], -0.03, 1e-15);
  EXPECT_NEAR(t[6], 0.03, 1e-15);
  EXPECT_LE(axisTicks(1e9, 1e9 + 1e-3, 6).size(), 13u);
}

TEST(AxisTicks, NothingToDivide) {
  EXPECT_TRUE(axisTicks(1, 1, 5).empty());
  EXPECT_TRUE(axisTicks(2, 1, 5).empty());
  EXPECT_TRUE(axisTicks(0, 1, 0).empty());
}

/// Remembers what was drawn.
class Recorder : public Canvas {
 public:
  void polyline(const std::vector<Vec2>& points, Color, double width) override {
    for (const Vec2& p : points) EXPECT_TRUE(p.allFinite());
    if (width == 1.5) lines.push_back(points);
  }
  void dot(const Vec2&, double, Color) override {}
  void polygon(const std::vector<Vec2>& outline, Color, double) override {
    for (const Vec2& p : outline) EXPECT_TRUE(p.allFinite());
    areas.push_back(outline);
  }
  void text(const Vec2&, const std::string& text, double, Anchor, Color, bool) override {
    all_text += text + "\n";
  }
  std::vector<std::vector<Vec2>> lines, areas;
  std::string all_text;
};

TEST(Draw, DataFarFromZeroLiesBetweenTheAxes) {
  Figure figure;
  Panel panel;
  panel.corner = {50, 30};
  panel.size = {400, 100};
  panel.curves.push_back({{0, 0, 0}, 1.5, {{{100, -7}, {101, -6}}}});
  figure.panels.push_back(panel);
  Recorder recorder;
  draw(figure, &recorder);
  ASSERT_EQ(recorder.lines.size(), 1u);
  const std::vector<Vec2>& p = recorder.lines[0];
  ASSERT_EQ(p.size(), 2u);
  EXPECT_NEAR(p[0].x() - 50, 450 - p[1].x(), 1e-6) << "the same margin on both sides";
  EXPECT_NEAR(p[1].y() - 30, 130 - p[0].y(), 1e-6);
  EXPECT_GT(p[1].x() - p[0].x(), 300);
  EXPECT_GT(p[0].y() - p[1].y(), 60);
}

TEST(Draw, EqualAspectKeepsASquareSquare) {
  Figure figure;
  Panel panel;
  panel.equal_aspect = true;
  panel.size = {400, 100};
  panel.curves.push_back({{0, 0, 0}, 1.5, {{{0, 0}, {1, 0}, {1, 1}}}});
  figure.panels.push_back(panel);
  Recorder recorder;
  draw(figure, &recorder);
  ASSERT_EQ(recorder.lines.size(), 1u);
  const auto& p = recorder.lines[0];
  ASSERT_EQ(p.size(), 3u);
  EXPECT_NEAR(p[1].x() - p[0].x(), p[1].y() - p[2].y(), 1e-9);
  EXPECT_GT(p[1].x(), p[0].x());
  EXPECT_LT(p[2].y(), p[1].y());  // up is up
}

bool inside(const std::vector<Vec2>& points, const Panel& panel) {
  const Vec2 low = panel.corner.array() - 1e-9, high = (panel.corner + panel.size).array() + 1e-9;
  for (const Vec2& p : points) {
    if ((p.array() < low.array()).any() || (p.array() > high.array()).any()) return false;
  }
  return true;
}

TEST(Draw, WhatIsOutOfScaleIsCutAtTheFrame) {
  Figure figure;
  Panel panel;
  panel.corner = {50, 60};
  panel.size = {400, 100};
  panel.extent = {{0, 0}, {10, 10}};
  panel.curves.push_back(
      {{0, 0, 0}, 1.5, {{{-100, 5}, {5, 5}, {5, 500}, {6, 500}, {6, 5}}}, false});
  panel.areas.push_back({{0, 0, 0}, 0.2, {{-100, 2}, {100, 2}, {100, 8}, {-100, 8}}});
  panel.areas.push_back({{0, 0, 0}, 0.2, {{-100, 200}, {100, 200}, {0, 300}}});
  figure.panels.push_back(panel);
  Recorder recorder;
  draw(figure, &recorder);
  ASSERT_EQ(recorder.lines.size(), 2u) << "it leaves and comes back";
  EXPECT_NEAR(recorder.lines[0].front().x(), 50, 1e-9);
  EXPECT_NEAR(recorder.lines[0].back().y(), 60, 1e-9);
  ASSERT_EQ(recorder.areas.size(), 1u) << "the second is wholly outside";
  for (const auto& points : recorder.lines) EXPECT_TRUE(inside(points, panel));
  EXPECT_TRUE(inside(recorder.areas[0], panel));
  double width = 0;
  for (const Vec2& p : recorder.areas[0]) width = std::max(width, p.x() - panel.corner.x());
  EXPECT_NEAR(width, 400, 1e-9);
}

TEST(Draw, MarksAndExtentStretchTheAxes) {
  Figure figure;
  Panel panel;
  panel.size = {100, 100};
  panel.marks.push_back({{-20, 3}, {0, 0, 0}, 4, Mark::Shape::cross, "here"});
  panel.extent = {{30, 4}};
  figure.panels.push_back(panel);
  Recorder recorder;
  draw(figure, &recorder);
  EXPECT_NE(recorder.all_text.find("-20"), std::string::npos) << recorder.all_text;
  EXPECT_NE(recorder.all_text.find("\n20\n"), std::string::npos);
  EXPECT_NE(recorder.all_text.find("here"), std::string::npos);
}

TEST(EllipseOutline, LiesOnTheEllipse) {
  Eigen::Matrix2d c;
  c << 4, 1, 1, 2;
  const Vec2 centre(3, -1);
  const auto outline = ellipseOutline(centre, c, 2);
  ASSERT_GT(outline.size(), 30u);
  for (const Vec2& p : outline) {
    EXPECT_NEAR((p - centre).dot(c.inverse() * (p - centre)), 4, 1e-9);
  }
  EXPECT_EQ(outline.front(), outline.back());
  EXPECT_TRUE(ellipseOutline(Vec2(NAN, 0), c, 2).empty());
  for (const Vec2& p : ellipseOutline(centre, -c, 2)) EXPECT_EQ(p, centre);
}

TEST(PathStrokes, CutsAtHoles) {
  Trajectory path = test::winding(4, 20);
  EXPECT_EQ(pathStrokes(path, 0, 1, holeOf(path)).size(), 1u);
  for (std::size_t i = path.size() / 2; i < path.size(); ++i) path[i].t += 2'000'000'000;
  EXPECT_EQ(pathStrokes(path, 0, 1, holeOf(path)).size(), 2u);
  Trajectory slow;
  for (int i = 0; i < 9; ++i) slow.push_back({i * 1'000'000'000LL, Pose()});
  EXPECT_EQ(pathStrokes(slow, 0, 1, holeOf(slow)).size(), 1u) << "one pose a second is no hole";
}

TEST(ComparisonFigure, HasAxesUnitsAndLegendAndSurvivesStandingStill) {
  const Trajectory moving = test::winding(20, 20);
  Trajectory still = moving;
  for (StampedPose& p : still) p.T_W_B.p = Vec3(1, 1, 1);
  for (const Trajectory& ref : {moving, still}) {
    const EvaluationResult r = evaluate(ref, test::noisy(ref, 0.01, 0.01, 1), {});
    Recorder recorder;
    draw(comparisonFigure(ref, {{"mine & <yours>", r}, {"again", r}}, "how"), &recorder);
    for (const char* word : {"x [m]", "z [m]", "error [m]", "error [deg]", "[s]", "again: ATE 0.0",
                             "reference", "From above", "From the side", "how"}) {
      EXPECT_NE(recorder.all_text.find(word), std::string::npos) << word;
    }
    const std::string svg = toSvg(comparisonFigure(ref, {{"mine & <yours>", r}}, "how"));
    EXPECT_NE(svg.find("mine &amp; &lt;yours&gt;"), std::string::npos);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
  }
}

TEST(ComparisonFigure, Empty) { EXPECT_TRUE(comparisonFigure({}, {}, "").panels.empty()); }

}  // namespace
}  // namespace vir::evaluation
