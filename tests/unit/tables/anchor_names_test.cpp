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
  for (const char* bad : {"", "nan", "inf", " a", "a ", "8 9", "x;y", "a'b", "a=b", "a\nb", "3.5"})
    EXPECT_EQ(of(bad), -999) << bad;
}

TEST(AnchorNames, OfAnyLanguageAndWithBlanks) {
  AnchorNames names;
  std::int32_t a = 0, b = 0;
  EXPECT_TRUE(names.numberOf("north wall", &a));
  EXPECT_TRUE(names.numberOf("T\xc3\xbcr", &b));  // UTF-8
  EXPECT_EQ(a, 1000000);
  EXPECT_EQ(b, 1000001);
  EXPECT_TRUE(names.numberOf("T\xfcr", &b));  // Latin-1
  EXPECT_EQ(b, 1000001);
  EXPECT_EQ(names.remarks(),
            "// anchor 1000001 is 'T\xc3\xbcr'\n// anchor 1000000 is 'north wall'\n");
}

TEST(AnchorNames, ARemarkIsOneShortLineOfText) {
  AnchorNames names;
  names.numberOfAny("x'\n[Imu]\nacc = 1");
  EXPECT_EQ(names.remarks(), "// anchor 1000000 is 'x'?[Imu]?acc = 1'\n");
  EXPECT_EQ(shownName(std::string(63, 'a') + "\xc3\xbc"), std::string(63, 'a'));
  EXPECT_EQ(shownName("\xed\xfc\x80"), "\xc3\xad\xc3\xbc\xc2\x80");
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
