#include "vir/evaluation/figure.h"

#include <gtest/gtest.h>

#include "made_trajectories.h"

namespace vir {
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
  void polygon(const std::vector<Vec2>& points, Color) override { polygons.push_back(points); }
  void dot(const Vec2& centre, double, Color) override { dots.push_back(centre); }
  void text(const Vec2&, const std::string& text, double, Anchor, Color, bool) override {
    all_text += text + "\n";
  }
  std::vector<std::vector<Vec2>> lines, polygons;
  std::vector<Vec2> dots;
  std::string all_text;
};

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

TEST(Draw, BandsAndPointsStayInsideTheAxes) {
  Figure figure;
  Panel panel;
  panel.corner = {50, 20};
  panel.size = {400, 100};
  panel.bands.push_back({{200, 200, 200}, {{0, 2}, {1, 3}}, {{0, -2}, {1, 1}}});
  panel.scatters.push_back({{0, 0, 0}, 1.5, {{-1, 0}, {2, 5}}});
  figure.panels.push_back(panel);
  Recorder recorder;
  draw(figure, &recorder);
  ASSERT_EQ(recorder.polygons.size(), 1u);
  ASSERT_EQ(recorder.polygons[0].size(), 4u);
  // Along the upper edge and back along the lower one.
  EXPECT_LT(recorder.polygons[0][0].x(), recorder.polygons[0][1].x());
  EXPECT_GT(recorder.polygons[0][2].x(), recorder.polygons[0][3].x());
  ASSERT_EQ(recorder.dots.size(), 2u);
  for (const Vec2& p : recorder.dots) {
    EXPECT_GE(p.x(), 50);
    EXPECT_LE(p.x(), 450);
    EXPECT_GT(p.y(), 20);
    EXPECT_LT(p.y(), 120);
  }
  EXPECT_NE(toSvg(figure).find("<polygon"), std::string::npos);
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
}  // namespace vir
