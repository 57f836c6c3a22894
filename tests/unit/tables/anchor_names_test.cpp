#include "vir/tables/anchor_names.h"

#include <gtest/gtest.h>

namespace vir::tables {
namespace {

TEST(AnchorNames, NumbersStayAndNamesGetOne) {
  AnchorNames names;
  const auto of = [&](const char* name) {
    std::int32_t n = -999;
    return names.numberOf(name, &n) ? n : -999;
  };
  EXPECT_EQ(of("7"), 7);
  EXPECT_EQ(of("7.0"), 7);
  EXPECT_EQ(of("-3"), -3);
  EXPECT_EQ(of("0x84"), 0x84);
  EXPECT_EQ(of("200A"), 1000000);
  EXPECT_EQ(of("9412036502"), 1000001);  // more than 32 bits
  EXPECT_EQ(of("200A"), 1000000);
  EXPECT_EQ(of("1000000"), 1000002);  // would be taken for 200A
  EXPECT_EQ(of("00:11:22:aa"), 1000003);
  EXPECT_EQ(of("12E4"), 1000004);  // hexadecimal, not 120000
  EXPECT_EQ(names.mapped().size(), 5u);
  for (const char* bad : {"", "nan", "inf", "a b", "x;y", "3.5"}) EXPECT_EQ(of(bad), -999) << bad;
}

TEST(AnchorNames, WhateverAMessageCallsAnAnchor) {
  AnchorNames names;
  EXPECT_EQ(names.numberOfAny("7"), 7);
  EXPECT_EQ(names.numberOfAny("0x84"), 0x84);
  EXPECT_EQ(names.numberOfAny("/uwb/range"), 1000000);
  EXPECT_EQ(names.numberOfAny("-3"), 1000001);
  EXPECT_EQ(names.numberOfAny(""), 1000002);
  EXPECT_EQ(names.numberOfAny("/uwb/range"), 1000000);
}

}  // namespace
}  // namespace vir::tables
