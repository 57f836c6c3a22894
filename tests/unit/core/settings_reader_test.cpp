/// Each wrong value is refused in its own words; nothing is rounded, cut or ignored.
#include "settings_errors.h"

namespace vir {
namespace {

using test::settingsErrorOf;

struct Options {
  bool flag = true;
  int count = 5;
  double size_m = 0.5;
  std::string name = "default";
  std::vector<double> offsets{1, 2, 3};
  std::string mode = "position";
};

void describe(OptionVisitor& v, Options& o) {
  v.section("Part", "A part");
  v.value("flag", o.flag, "a flag");
  v.value("count", o.count, {1, 10}, "a count");
  v.value("size_m", o.size_m, {0, 1e9}, "a size");
  v.value("name", o.name, "a name");
  v.value("offsets", o.offsets, 3, "three numbers");
  v.choice("mode", o.mode, {"none", "position"}, "a mode");
}

Options read(const std::string& body) {
  const Settings settings = Settings::fromText("[Part]\n" + body + "\n", "x.ini");
  SettingsReader reader(settings);
  Options o;
  describe(reader, o);
  reader.finish();
  return o;
}

std::string errorOf(const std::string& body) {
  return settingsErrorOf([&] { read(body); });
}

TEST(SettingsReader, ReadsEveryKind) {
  const Options o = read(
      "flag = No\ncount = +7\nsize_m = 2.5e-1\nname = a b // c\noffsets = 1\t-2  3e1\nmode = NONE");
  EXPECT_FALSE(o.flag);
  EXPECT_EQ(o.count, 7);
  EXPECT_EQ(o.size_m, 0.25);
  EXPECT_EQ(o.name, "a b");
  EXPECT_EQ(o.offsets, (std::vector<double>{1, -2, 30}));
  EXPECT_EQ(o.mode, "none");
}

TEST(SettingsReader, WhatIsNotSetKeepsItsDefault) {
  const Options o = read("count = 6");
  EXPECT_TRUE(o.flag);
  EXPECT_EQ(o.size_m, 0.5);
  EXPECT_EQ(o.name, "default");
  EXPECT_EQ(o.mode, "position");
}

TEST(SettingsReader, Flags) {
  for (const std::string yes : {"true", "YES", "1"}) EXPECT_TRUE(read("flag = " + yes).flag);
  for (const std::string no : {"false", "No", "0"}) EXPECT_FALSE(read("flag = " + no).flag);
  for (const std::string wrong : {"maybe", "", "2", "truee", "on"}) {
    EXPECT_EQ(errorOf("flag = " + wrong),
              "x.ini:2: [Part] flag = " + wrong +
                  ": not a yes or no; allowed: true, false, yes, no, 1, 0");
  }
}

TEST(SettingsReader, WholeNumbers) {
  for (const std::string wrong : {"abc", "3.7", "3 4", "7x", "", "0x7", "nan", "--3"}) {
    EXPECT_EQ(errorOf("count = " + wrong),
              "x.ini:2: [Part] count = " + wrong +
                  ": not a whole number; allowed: a whole number from 1 to 10");
  }
  for (const std::string wrong : {"0", "11", "-3", "99999999999999999999"}) {
    EXPECT_EQ(errorOf("count = " + wrong),
              "x.ini:2: [Part] count = " + wrong +
                  ": out of bounds; allowed: a whole number from 1 to 10");
  }
  EXPECT_EQ(read("count = $eval{3*3}").count, 9);
}

TEST(SettingsReader, Numbers) {
  for (const std::string wrong : {"abc", "1,5", "1.5m", "", "inf", "nan", "1e999"}) {
    EXPECT_EQ(
        errorOf("size_m = " + wrong),
        "x.ini:2: [Part] size_m = " + wrong + ": not a number; allowed: a number from 0 to 1e+09");
  }
  EXPECT_EQ(errorOf("size_m = -1e-9"),
            "x.ini:2: [Part] size_m = -1e-9: out of bounds; allowed: a number from 0 to 1e+09");
}

TEST(SettingsReader, Lists) {
  EXPECT_EQ(errorOf("offsets = 1 2"),
            "x.ini:2: [Part] offsets = 1 2: 2 numbers; allowed: 3 numbers with blanks between");
  EXPECT_EQ(errorOf("offsets = 1 b 3"),
            "x.ini:2: [Part] offsets = 1 b 3: 'b' is not a number; allowed: 3 numbers with blanks "
            "between");
}

TEST(SettingsReader, Choices) {
  EXPECT_EQ(errorOf("mode = pose"),
            "x.ini:2: [Part] mode = pose: not one of the choices; allowed: none, position");
}

TEST(SettingsReader, UnknownKeyWithTheNearestKnown) {
  EXPECT_EQ(errorOf("cuont = 3"), "x.ini:2: [Part] cuont: unknown key; did you mean count?");
  EXPECT_EQ(errorOf("zzzzzzzz = 3"),
            "x.ini:2: [Part] zzzzzzzz: unknown key. Known keys: count, flag, mode, name, offsets, "
            "size_m");
}

TEST(SettingsReader, UnknownSection) {
  EXPECT_EQ(errorOf("[Prat]\na = 1"),
            "x.ini:2: [Prat] unknown section; did you mean [Part]? Known sections: Part");
}

TEST(SettingsReader, SectionsOfOthersAreLeftToThem) {
  const Settings settings = Settings::fromText("[Part]\ncount = 3\n[Other]\na = 1\n", "x.ini");
  SettingsReader reader(settings);
  Options o;
  describe(reader, o);
  reader.ignoreSection("other");
  EXPECT_NO_THROW(reader.finish());
}

TEST(SettingsReader, ASectionMayHaveTwoReaders) {
  const Settings settings = Settings::fromText("[Part]\ncount = 3\ndriver = x\n", "x.ini");
  SettingsReader reader(settings);
  std::string driver;
  reader.section("part", "");
  reader.value("driver", driver, "");
  EXPECT_EQ(settingsErrorOf([&] { reader.finish(); }),
            "x.ini:2: [Part] count: unknown key. Known keys: driver");
  Options o;
  describe(reader, o);
  EXPECT_NO_THROW(reader.finish());
  EXPECT_EQ(driver, "x");
}

TEST(SettingsReader, ACompanionFileMayHoldMore) {
  Settings settings = Settings::fromText("[Part]\ncount = 3\n", "x.ini");
  settings.mergeDefaults(Settings::fromText("[Part]\nfuture = 1\n[Future]\na = 1\n", "y.ini"));
  SettingsReader reader(settings);
  Options o;
  describe(reader, o);
  EXPECT_EQ(settingsErrorOf([&] { reader.finish(); }).rfind("y.ini:3: [Future]", 0), 0u);
  reader.ignoreUnknownFrom("y.ini");
  EXPECT_NO_THROW(reader.finish());
}

TEST(SettingsReader, WrongValueFromTheCommandLineSaysSo) {
  Settings settings = Settings::fromText("[Part]\ncount = 3\n", "x.ini");
  settings.set("Part.count=12");
  SettingsReader reader(settings);
  Options o;
  EXPECT_EQ(settingsErrorOf([&] { describe(reader, o); }),
            "--set: [Part] count = 12: out of bounds; allowed: a whole number from 1 to 10");
}

}  // namespace
}  // namespace vir
