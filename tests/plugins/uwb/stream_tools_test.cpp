/// What the parsers share.
#include <gtest/gtest.h>

#include "line_assembler.h"
#include "text_scanner.h"
#include "vir/core/crc.h"

namespace vir {
namespace {

const std::uint8_t* bytesOf(const char* text) {
  return reinterpret_cast<const std::uint8_t*>(text);
}

/// Check values of the catalogue of CRCs: of the characters 1 to 9.
TEST(Crc, CheckValues) {
  EXPECT_EQ(crc16Ccitt(bytesOf("123456789"), 9), 0x29B1);
  EXPECT_EQ(crc16Mavlink(bytesOf("123456789"), 9), 0x6F91);
  EXPECT_EQ(crc16Mavlink(bytesOf("6789"), 4, crc16Mavlink(bytesOf("12345"), 5)), 0x6F91);
}

TEST(LineAssembler, EndsFragmentsAndLongLines) {
  LineAssembler lines(8);
  std::vector<LineAssembler::Line> got;
  const auto feed = [&](const std::string& text) {
    lines.feed(bytesOf(text.c_str()), text.size(), &got);
  };
  feed("abc");
  EXPECT_TRUE(got.empty());
  EXPECT_EQ(lines.begun(), "abc");
  feed("d\r\n\nsecond\r0123456789\nlast\n");
  ASSERT_EQ(got.size(), 4u);
  EXPECT_EQ(got[0].text, "abcd");
  EXPECT_TRUE(got[0].fragment);
  EXPECT_EQ(got[1].text, "second");
  EXPECT_FALSE(got[1].fragment);
  EXPECT_EQ(got[2].text, "01234567");
  EXPECT_TRUE(got[2].too_long);
  EXPECT_EQ(got[3].text, "last");
  EXPECT_FALSE(got[3].too_long);
  feed(std::string(100000, 'x'));
  EXPECT_LE(lines.buffered(), 8u);
  lines.reset();
  got.clear();
  feed("y\n");
  EXPECT_TRUE(got.at(0).fragment);
}

TEST(TextScanner, NumbersAreTakenWholeOrNotAtAll) {
  double v = 0;
  for (const char* good : {"1", "-1.5", "0.001", "2.", "1e-3", "1E+2"}) {
    TextScanner s(good);
    EXPECT_TRUE(s.number(&v) && s.atEnd()) << good;
  }
  for (const char* bad : {"", "-", ".5", "nan", "inf", "+1", "1e", "1e999", "0x10", "e5"}) {
    TextScanner s(bad);
    EXPECT_FALSE(s.number(&v) && s.atEnd()) << bad;
  }
  EXPECT_TRUE(TextScanner("3.44").fixed(2, &v));
  EXPECT_DOUBLE_EQ(v, 3.44);
  for (const char* bad : {"3.4", "3.444", "3", ".44", "3,44", "-"}) {
    EXPECT_FALSE(TextScanner(bad).fixed(2, &v)) << bad;
  }
  std::int64_t i = 0;
  EXPECT_TRUE(TextScanner("-12").integer(&i));
  EXPECT_EQ(i, -12);
  EXPECT_FALSE(TextScanner("1234567890123456789").integer(&i));
  EXPECT_TRUE(TextScanner("1aF").hex(1, 4, &i));
  EXPECT_EQ(i, 0x1AF);
  EXPECT_FALSE(TextScanner("12345").hex(1, 4, &i));
  EXPECT_FALSE(TextScanner("123").hex(4, 4, &i));
}

}  // namespace
}  // namespace vir
