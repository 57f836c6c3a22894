#include "vir/ranging/range_bias_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace {

using vir::ranging::RangeBiasModel;
using vir::ranging::RangeBiasModelError;

RangeBiasModel made() {
  return RangeBiasModel({{1, 0.10, 0.01}, {2, 0.14, 0.005}, {4, 0.02, 0.01}, {5, 0.03, 0.02}},
                        0.043);
}

TEST(RangeBiasModel, EmptyIsNoBias) {
  const RangeBiasModel none;
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(none.at(7).mean_m, 0);
  EXPECT_EQ(none.at(7).sigma_m, 0);
  EXPECT_EQ(none.corrected(7), 7);
}

TEST(RangeBiasModel, PassesThroughItsNodes) {
  const RangeBiasModel model = made();
  for (const auto& n : model.nodes()) {
    EXPECT_NEAR(model.at(n.distance_m).mean_m, n.bias_m, 1e-15);
    EXPECT_NEAR(model.at(n.distance_m).sigma_m, n.sigma_m, 1e-15);
  }
  EXPECT_NEAR(model.at(3).sigma_m, 0.0075, 1e-15);
}

TEST(RangeBiasModel, SlopeIsTheDerivativeAndContinuous) {
  const RangeBiasModel model = made();
  for (double d = 0.5; d < 6; d += 0.0371) {
    const double numeric = (model.at(d + 1e-6).mean_m - model.at(d - 1e-6).mean_m) / 2e-6;
    EXPECT_NEAR(model.at(d).slope, numeric, 1e-6) << d;
  }
  for (const double d : {1.0, 2.0, 4.0, 5.0}) {
    EXPECT_NEAR(model.at(d - 1e-9).slope, model.at(d + 1e-9).slope, 1e-6) << d;
  }
}

TEST(RangeBiasModel, BeyondTheTableTheLastValueWithGrowingSigma) {
  const RangeBiasModel model = made();
  EXPECT_EQ(model.at(0.2).mean_m, 0.10);
  EXPECT_EQ(model.at(50).mean_m, 0.03);
  EXPECT_EQ(model.at(50).slope, 0);
  EXPECT_GT(model.at(50).sigma_m, 0.5);
  EXPECT_GT(model.at(6).sigma_m, model.at(5).sigma_m);
  EXPECT_EQ(model.at(std::numeric_limits<double>::quiet_NaN()).mean_m, 0);
}

TEST(RangeBiasModel, CorrectedUndoesIt) {
  const RangeBiasModel model = made();
  for (double d = 0.5; d < 6; d += 0.1) {
    EXPECT_NEAR(model.corrected(d + model.at(d).mean_m), d, 1e-6) << d;
  }
}

TEST(RangeBiasModel, TextReadsBackExactly) {
  const RangeBiasModel model({{0.1, 1.0 / 3, 0.01}, {7, -0.2, 0}}, 0.1 / 3);
  const RangeBiasModel back = RangeBiasModel::fromText(model.text());
  ASSERT_EQ(back.nodes().size(), 2u);
  EXPECT_EQ(back.nodes()[0].bias_m, 1.0 / 3);
  EXPECT_EQ(back.nodes()[1].bias_m, -0.2);
  EXPECT_EQ(back.text(), model.text());
  EXPECT_TRUE(RangeBiasModel::fromText(RangeBiasModel().text()).empty());
  // As an editor on another system leaves it.
  std::string dos;
  for (const char c : model.text()) dos += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(RangeBiasModel::fromText(dos).nodes().size(), 2u);
}

TEST(RangeBiasModel, WhatIsWrongIsNamedWithItsLine) {
  const std::string head = "# vir-slam range bias model 1\ndistance_m,bias_m,sigma_m\n";
  const auto error = [](const std::string& text) -> std::string {
    try {
      RangeBiasModel::fromText(text, "b.csv");
    } catch (const RangeBiasModelError& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_EQ(error(head + "1,2,3\n"), "no error");
  EXPECT_EQ(error(""),
            "b.csv:0: empty or cut off: the header 'distance_m,bias_m,sigma_m' is missing");
  EXPECT_NE(error("1,2,3\n").find("b.csv:1: not a bias model"), std::string::npos);
  EXPECT_NE(error("# vir-slam range bias model 1\n1,2,3\n").find("b.csv:2: expected the header"),
            std::string::npos);
  EXPECT_NE(error(head + "1,2\n").find("b.csv:3: expected 3 numbers"), std::string::npos);
  EXPECT_NE(error(head + "1,2,3,4\n").find("found 4"), std::string::npos);
  EXPECT_NE(error(head + "1,abc,3\n").find("'abc' is no finite number"), std::string::npos);
  EXPECT_NE(error(head + "1,nan,3\n").find("'nan'"), std::string::npos);
  EXPECT_NE(error(head + "2,0,1\n1,0,1\n").find("b.csv:4: distances must ascend"),
            std::string::npos);
  EXPECT_NE(error(head + "-1,0,1\n").find("negative"), std::string::npos);
  EXPECT_NE(error(head + "1,0,-1\n").find("negative"), std::string::npos);
  EXPECT_NE(error("# vir-slam range bias model 1\n# noise_sigma_m = x\n").find("noise"),
            std::string::npos);
  EXPECT_THROW(RangeBiasModel({{1, 0, 0}, {1, 0, 0}}), RangeBiasModelError);
  EXPECT_THROW(RangeBiasModel({}, -1), RangeBiasModelError);
}

}  // namespace
