#include "vir/ranging/survey_table.h"

#include <gtest/gtest.h>

namespace vir::ranging {
namespace {

std::string refusalOf(const std::string& text) {
  try {
    surveyFromText(text, "anchors.csv", {{"north", 1000001}});
  } catch (const SurveyTableError& e) {
    return e.what();
  }
  return "";
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(SurveyTable, ColumnsByName) {
  const auto a = surveyFromText(
      "# our hall\nname, z, y, x, sigma_m\n3, 2.5, 0, 1.5, 0.02\n0x84, 3,9 , 12,\nnorth,1,2,3,0.1\n"
      "200A,1,1,1,0.3\n",
      "anchors.csv", {{"north", 1000001}});
  ASSERT_EQ(a.size(), 4u);
  EXPECT_EQ(a[0].id, 3u);
  EXPECT_EQ(a[0].p_S, Vec3(1.5, 0, 2.5));
  EXPECT_EQ(a[0].sigma_m, 0.02);
  EXPECT_EQ(a[1].id, 0x84u);
  EXPECT_EQ(a[1].sigma_m, 0.05) << "not given";
  EXPECT_EQ(a[2].id, 1000001u);
  EXPECT_EQ(a[3].id, 0x200Au) << "as devices print it";
}

TEST(SurveyTable, AsImportersWriteTruePositions) {
  const auto a = surveyFromText("#id,x,y,z in the ground truth's frame [m]\n0,-3,4,2.5\n", "x");
  ASSERT_EQ(a.size(), 1u);
  EXPECT_EQ(a[0].p_S, Vec3(-3, 4, 2.5));
}

TEST(SurveyTable, WithoutAHeaderAndWithUnits) {
  auto a = surveyFromText("1 0.5 2 3\n2 4 5 6 0.1\n", "x");
  ASSERT_EQ(a.size(), 2u);
  EXPECT_EQ(a[0].p_S, Vec3(0.5, 2, 3));
  EXPECT_EQ(a[1].sigma_m, 0.1);
  a = surveyFromText("#id,x [mm],y [mm],z [mm],sigma [mm]\r\n7,1500,-2000,300,20\r\n", "x");
  ASSERT_EQ(a.size(), 1u);
  EXPECT_NEAR((a[0].p_S - Vec3(1.5, -2, 0.3)).norm(), 0, 1e-12);
  EXPECT_NEAR(a[0].sigma_m, 0.02, 1e-12);
}

TEST(SurveyTable, WhatCannotBeIsNamedWithItsLine) {
  EXPECT_TRUE(has(refusalOf("id,x,y,z\n1,2,3\n"), "anchors.csv:2"))
      << refusalOf("id,x,y,z\n1,2,3\n");
  EXPECT_TRUE(has(refusalOf("id,x,y,z\n1,2,3,nan\n"), "anchors.csv:2: 'nan'"));
  EXPECT_TRUE(has(refusalOf("id,x,y,z\n1,2,3,4\n1,2,3,5\n"), "anchors.csv:3: anchor 1"));
  EXPECT_TRUE(has(refusalOf("id,x,y,z\nsouth,2,3,4\n"), "'south' is no anchor"));
  EXPECT_TRUE(has(refusalOf("id,x,y,z,sigma\n1,2,3,4,0\n"), "sigma is 0"));
  EXPECT_TRUE(has(refusalOf("id,x,y,z\n99999999999,2,3,4\n"), "no anchor"));
  EXPECT_TRUE(has(refusalOf("id,lat,lon,z\n1,2,3,4\n"), "needed: id,x,y,z"));
  EXPECT_TRUE(has(refusalOf("id,x [furlong],y,z\n1,2,3,4\n"), "furlong"));
  EXPECT_TRUE(has(refusalOf(""), "no anchor"));
  EXPECT_TRUE(has(refusalOf("\x01\x02\xff\n"), "anchors.csv"));
  EXPECT_THROW(anchorNumbers("a=1 b"), std::runtime_error);
  EXPECT_EQ(anchorNumbers("a=1 b=c=22").at("b=c"), 22u);
  const AnchorNumbers odd{{"north wall", 5}, {"50 %20", 6}, {"T\xc3\xbcr", 7}};
  EXPECT_EQ(anchorNumbersText(odd), "50%20%2520=6 T\xc3\xbcr=7 north%20wall=5");
  EXPECT_EQ(anchorNumbers(anchorNumbersText(odd)), odd);
  EXPECT_EQ(surveyFromText("id,x,y,z\nnorth wall,1,2,3\nT\xfcr,1,2,4\n", "s.csv", odd)[1].id, 7u);
}

}  // namespace
}  // namespace vir::ranging
