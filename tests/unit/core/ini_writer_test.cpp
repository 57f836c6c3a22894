#include "vir/core/ini_writer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vir/core/settings.h"

namespace vir {
namespace {

struct Options {
  bool flag = true;
  int count = -5;
  double size_m = 0.1;
  std::string name = "a name";
  std::vector<double> offsets{1, 1.0 / 3, 3e-300};
  std::string mode = "none";
};

void describe(OptionVisitor& v, Options& o) {
  v.section("Part", "A part.");
  v.value("flag", o.flag, "A flag.");
  v.value("count", o.count, {}, "A count.");
  v.section("Other", "");
  v.value("name", o.name, "A name.");
  v.choice("mode", o.mode, {"none", "position"}, "A mode.");
  v.section("part", "again");
  v.value("size_m", o.size_m, {0, 1}, "A size.");
  v.value("offsets", o.offsets, 0, "Numbers.");
}

TEST(IniWriter, ValuesUnderOneHeadingEach) {
  Options o;
  IniWriter writer(IniWriter::Style::values);
  describe(writer, o);
  EXPECT_EQ(writer.text(),
            "[Part]\nflag = true\ncount = -5\nsize_m = 0.1\noffsets = 1 0.3333333333333333 3e-300\n"
            "\n[Other]\nname = a name\nmode = none\n");
}

TEST(IniWriter, ReferenceSaysWhatIsAllowed) {
  Options o;
  IniWriter writer(IniWriter::Style::reference);
  describe(writer, o);
  const std::string text = writer.text();
  EXPECT_NE(text.find("// A part.\n[Part]\n"), std::string::npos) << text;
  EXPECT_NE(
      text.find("\n// A size.\n// Allowed: a number from 0 to 1. Default: 0.1\nsize_m = 0.1\n"),
      std::string::npos)
      << text;
}

/// Whatever is written reads back as exactly the same values, comments or not.
TEST(IniWriter, RoundTrip) {
  for (const auto style : {IniWriter::Style::values, IniWriter::Style::reference}) {
    Options written;
    written.flag = false;
    written.size_m = std::sqrt(0.5);
    written.mode = "position";
    IniWriter writer(style);
    describe(writer, written);
    const Settings settings = Settings::fromText(writer.text(), "written.ini");
    SettingsReader reader(settings);
    Options back;
    describe(reader, back);
    reader.finish();
    EXPECT_EQ(back.flag, written.flag);
    EXPECT_EQ(back.count, written.count);
    EXPECT_EQ(back.size_m, written.size_m);
    EXPECT_EQ(back.name, written.name);
    EXPECT_EQ(back.offsets, written.offsets);
    EXPECT_EQ(back.mode, written.mode);
  }
}

}  // namespace
}  // namespace vir
