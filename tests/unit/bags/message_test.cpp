/// Definitions of messages and the bytes that they describe.
#include <gtest/gtest.h>

#include "bag_fixtures.h"

namespace vir::bags {
namespace {

std::string complaintOf(const std::string& text, Wire wire = Wire::ros1) {
  try {
    Definition::parse("pkg/A", text, wire);
    return "";
  } catch (const BagError& e) {
    return e.what();
  }
}

TEST(Definition, TakesWhatTheLanguageHas) {
  const auto d = Definition::parse("pkg/A",
                                   "# comment\n"
                                   "int32 X=4\n"
                                   "string NAME = with # no comment\n"
                                   "\n"
                                   "uint8[] a  # behind\n"
                                   "B[3] b\r\n"
                                   "pkg/B c\n"
                                   "time t\n"
                                   "===\nMSG: pkg/B\nfloat32 x\nchar k\n",
                                   Wire::ros1);
  const auto& f = d->root().fields;
  ASSERT_EQ(f.size(), 4u);
  EXPECT_TRUE(f[0].array);
  EXPECT_EQ(f[0].fixed_count, 0u);
  EXPECT_EQ(f[1].fixed_count, 3u);
  EXPECT_EQ(f[1].type, f[2].type);
  EXPECT_EQ(f[2].type->ros1_size, 5u);
  EXPECT_EQ(f[3].kind, Kind::time);
}

TEST(Definition, TakesDefaultsAndBoundsOfRos2) {
  const auto d = Definition::parse("pkg/msg/A",
                                   "string<=10 name \"a = b\"\n"
                                   "float64 x 1.5\n"
                                   "int32[<=4] few\n"
                                   "string<=3[<=2] two\n"
                                   "builtin_interfaces/Time t\n",
                                   Wire::cdr);
  const auto& f = d->root().fields;
  ASSERT_EQ(f.size(), 5u);
  EXPECT_EQ(d->root().name, "pkg/A");
  EXPECT_EQ(f[0].kind, Kind::text);
  EXPECT_FALSE(f[0].array);
  EXPECT_TRUE(f[2].array);
  EXPECT_EQ(f[2].fixed_count, 0u);
  EXPECT_TRUE(f[3].array);
  EXPECT_EQ(f[4].type->name, "builtin_interfaces/Time");
}

TEST(Definition, SaysWhichLineIsWrong) {
  EXPECT_NE(complaintOf("float64\n").find("`float64`"), std::string::npos);
  EXPECT_NE(complaintOf("Nowhere n\n").find("pkg/Nowhere"), std::string::npos);
  EXPECT_NE(complaintOf("uint8[x] n\n").find("length"), std::string::npos);
  EXPECT_NE(complaintOf("A a\n").find("contains itself"), std::string::npos);
  EXPECT_NE(complaintOf("time t\n", Wire::cdr).find("time"), std::string::npos);
}

TEST(Definition, ManyTypesWithinTypesCostLittle) {
  // Each twice in the next: 2^20 fields if they were written out.
  std::string text = "T0 a\nT0 b\n";
  for (int i = 0; i < 20; ++i) {
    const std::string next = "T" + std::to_string(i + 1);
    text += "===\nMSG: pkg/T" + std::to_string(i) + "\n" +
            (i == 19 ? "uint8 x\n" : next + " a\n" + next + " b\n");
  }
  const auto d = Definition::parse("pkg/A", text, Wire::ros1);
  EXPECT_EQ(d->root().ros1_size, 1u << 20);
}

TEST(MessageView, CdrKeepsToItsAlignment) {
  const auto d = Definition::parse("pkg/A",
                                   "uint8 a\nfloat64 b\nstring s\nuint16 c\nfloat64[] l\n"
                                   "int32[] none\nuint8 z\n",
                                   Wire::cdr);
  Bytes b = {0, 1, 0, 0};
  const auto put = [&](const void* p, std::size_t n, std::size_t align) {
    while ((b.size() - 4) % align != 0) b.push_back(0xEE);
    const auto* bytes = static_cast<const std::uint8_t*>(p);
    for (std::size_t i = 0; i < n; ++i) b.push_back(bytes[i]);
  };
  const std::uint8_t a = 7, z = 9;
  const double x = -2.5, l[2] = {3, 4};
  const std::uint32_t text = 4, two = 2, none = 0;
  const std::uint16_t c = 513;
  put(&a, 1, 1);
  put(&x, 8, 8);
  put(&text, 4, 4);
  put("abc", 4, 1);
  put(&c, 2, 2);
  put(&two, 4, 4);
  put(l, 16, 8);
  put(&none, 4, 4);
  put(&z, 1, 1);
  const MessageView m(*d, {b.data(), b.size()});
  EXPECT_EQ(m.integer("a"), 7);
  EXPECT_EQ(m.number("b"), -2.5);
  EXPECT_EQ(m.text("s"), "abc");
  EXPECT_EQ(m.integer("c"), 513);
  EXPECT_EQ(m.numbers("l", 9), (std::vector<double>{3, 4}));
  EXPECT_EQ(m.integer("z"), 9);
  EXPECT_THROW(m.numbers("l", 1), BagError);
  EXPECT_THROW(m.number("s"), BagError);
  EXPECT_THROW(m.number("nowhere"), BagError);
  EXPECT_FALSE(m.has("nowhere"));
  // Cut anywhere: the last field cannot be read, and nothing beyond the end is.
  for (std::size_t n = 0; n < b.size(); ++n) {
    const Bytes part(b.begin(), b.begin() + static_cast<std::ptrdiff_t>(n));
    EXPECT_THROW(MessageView(*d, {part.data(), part.size()}).integer("z"), BagError) << n;
  }
}

TEST(MessageView, HighestByteFirstIsReadToo) {
  const auto d = Definition::parse("pkg/A", "uint16 a\nuint32 b\n", Wire::cdr);
  const Bytes b = {0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 1, 0};
  const MessageView m(*d, {b.data(), b.size()});
  EXPECT_EQ(m.integer("a"), 258);
  EXPECT_EQ(m.integer("b"), 256);
}

TEST(MessageView, AFieldThatIsMissingIsSaidWithThoseThatAreThere) {
  const auto d = Definition::parse("pkg/A", "uint8 id\nuint8 distance\n", Wire::ros1);
  const Bytes b = {1, 2};
  const MessageView m(*d, {b.data(), b.size()});
  try {
    m.integer("anchor_id");
    FAIL() << "found";
  } catch (const BagError& e) {
    EXPECT_STREQ(e.what(), "pkg/A has no field anchor_id; it has id, distance");
  }
}

TEST(MessageView, ListsThatClaimMoreThanThereIsAreNoticedAtOnce) {
  const auto d =
      Definition::parse("pkg/A", "B[] l\nuint8 z\n===\nMSG: pkg/B\nstring s\n", Wire::ros1);
  const Bytes b = {0xFF, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  EXPECT_THROW(MessageView(*d, {b.data(), b.size()}).integer("z"), BagError);
  // Elements without bytes: any number of them is nothing.
  const auto empty = Definition::parse("pkg/A", "B[] l\nuint8 z\n===\nMSG: pkg/B\n\n", Wire::ros1);
  const MessageView m(*empty, {b.data(), b.size()});
  EXPECT_EQ(m.integer("z"), 0);
  int n = 0;
  m.each("l", [&](const MessageView&) { ++n; });
  EXPECT_EQ(n, 0);
}

}  // namespace
}  // namespace vir::bags
