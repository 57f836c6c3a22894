/// The ini syntax: what MRPT offers works, what MRPT passes over in silence is an error.
#include <mrpt/config/CConfigFileMemory.h>

#include <filesystem>

#include "settings_errors.h"
#include "vir_test_temp_folder.h"

namespace vir {
namespace {

using test::settingsErrorOf;

std::string valueOf(const Settings& s, const std::string& section, const std::string& key) {
  const Setting* setting = s.find(section, key);
  return setting == nullptr ? "(not set)" : setting->value;
}

std::string textError(const std::string& text) {
  return settingsErrorOf([&] { Settings::fromText(text, "x.ini"); });
}

TEST(Settings, CommentsAndBlanks) {
  const Settings s = Settings::fromText(
      "\xEF\xBB\xBF// head\r\n[A] // first\r\n; c\r\n# c\r\n  a = 1 // one\r\nb = rtsp://x/y ; "
      "c\r\n"
      "c=two words # c\r\nempty =\r\ncolour = a#b\r\n",
      "x.ini");
  EXPECT_EQ(valueOf(s, "A", "a"), "1");
  EXPECT_EQ(valueOf(s, "A", "b"), "rtsp://x/y");
  EXPECT_EQ(valueOf(s, "A", "c"), "two words");
  EXPECT_EQ(valueOf(s, "A", "empty"), "");
  EXPECT_EQ(valueOf(s, "A", "colour"), "a#b");
  EXPECT_EQ(valueOf(s, "a", "COLOUR"), "a#b");  // names are not case-sensitive
}

TEST(Settings, ExpansionsOfMrptAndTheirLines) {
  const Settings s = Settings::fromText(
      "@define W 7\n[A]\n// ${ONLY_EXPLAINED}\nw = ${W}\ne = $eval{2*W+1}\nlist = 1 2 \\\n 3\nz = "
      "4\n",
      "x.ini");
  EXPECT_EQ(valueOf(s, "A", "w"), "7");
  EXPECT_DOUBLE_EQ(std::stod(valueOf(s, "A", "e")), 15.0);
  EXPECT_EQ(valueOf(s, "A", "list"), "1 2  3");
  EXPECT_EQ(s.find("A", "list")->origin.line, 6);
  EXPECT_EQ(s.find("A", "z")->origin.line, 8);
  EXPECT_EQ(s.find("A", "z")->origin.file, "x.ini");
}

TEST(Settings, SameAsMrptWhereMrptIsRight) {
  const std::string text =
      "@define N 3\n[One]\na = ${N}\nb = x y\nc = $eval{N*N}\n[Two]\nd = 5 // five\n";
  const Settings ours = Settings::fromText(text, "x.ini");
  mrpt::config::CConfigFileMemory theirs;
  theirs.setContent(text);
  for (const Setting& s : ours.all()) {
    std::string value = theirs.read_string(s.section, s.key, "(not set)");
    value.erase(value.find_last_not_of(' ') + 1);
    EXPECT_EQ(s.value, value) << s.section << "." << s.key;
  }
  EXPECT_EQ(ours.all().size(), 4u);
}

TEST(Settings, MalformedLines) {
  EXPECT_EQ(textError("[A]\na = 1\njunk\n"),
            "x.ini:3: [A] malformed line 'junk'; expected key = value");
  EXPECT_EQ(textError("[A]\n = 5\n"), "x.ini:2: [A] malformed line '= 5'; expected key = value");
  EXPECT_EQ(textError("[A\na = 1\n"), "x.ini:1: malformed section line '[A'; expected [Name]");
  EXPECT_EQ(textError("[A] b\na = 1\n"),
            "x.ini:1: malformed section line '[A] b'; expected [Name]");
  EXPECT_EQ(textError("[]\na = 1\n"), "x.ini:1: malformed section line '[]'; expected [Name]");
  EXPECT_EQ(textError("a = 1\n[A]\n"), "x.ini:1: a: stands before the first [Section]");
}

TEST(Settings, RepeatedKey) {
  EXPECT_EQ(textError("[A]\na = 1\n[B]\na = 2\n[a]\nA = 3\n"),
            "x.ini:6: [a] A: repeated; first set on line 2. Remove one of the two");
}

TEST(Settings, ExpansionErrorsNameTheLine) {
  EXPECT_EQ(textError("[A]\na = ${NOPE}\n"), "x.ini:2: Line 2: Unknown variable `${NOPE}`");
  const std::string formula = textError("[A]\n\n\na = $eval{1+}\n");
  EXPECT_EQ(formula.rfind("x.ini:4: ", 0), 0u) << formula;
  EXPECT_EQ(formula.find('\n'), std::string::npos) << formula;
}

TEST(Settings, Files) {
  const test::TempFolder folder;
  const std::string missing = (folder / "no.ini").string();
  EXPECT_EQ(settingsErrorOf([&] { Settings::fromFile(missing); }),
            missing + ": there is no such settings file");
  EXPECT_EQ(settingsErrorOf([&] { Settings::fromFile(folder.path().string()); }),
            folder.path().string() + ": this is a folder, not a settings file");
  const std::filesystem::path huge = folder / "huge.ini";
  test::writeText(huge, "[A]\nkey = 1\n");
  std::filesystem::resize_file(huge, 17'000'000);
  EXPECT_EQ(
      settingsErrorOf([&] { Settings::fromFile(huge.string()); }),
      huge.string() +
          ": cannot read the settings file: it is larger than 16000 kB, which no such file is");
  for (const std::string text : {"", "\n\n", "// only a comment\n", "[A]\n"}) {
    test::writeText(folder / "empty.ini", text);
    EXPECT_EQ(settingsErrorOf([&] { Settings::fromFile((folder / "empty.ini").string()); }),
              (folder / "empty.ini").string() + ": there is no setting in this file");
  }
  test::writeText(folder / "junk.ini", std::string("\0\x01\x02[\xff\n\0", 8));
  EXPECT_NE(settingsErrorOf([&] { Settings::fromFile((folder / "junk.ini").string()); }),
            "no SettingsError");
  test::writeText(folder / "good.ini", "[A]\na = 1");
  EXPECT_EQ(valueOf(Settings::fromFile((folder / "good.ini").string()), "A", "a"), "1");
}

TEST(Settings, CommandLineGoesBeforeTheFile) {
  Settings s = Settings::fromText("[A]\na = 1\n", "x.ini");
  s.set("a.A=2");
  s.set("B.path = x.y=z ");
  EXPECT_EQ(valueOf(s, "A", "a"), "2");
  EXPECT_EQ(s.find("A", "a")->origin.file, "--set");
  EXPECT_EQ(valueOf(s, "B", "path"), "x.y=z");
  for (const std::string wrong : {"", "a", "a=1", ".a=1", "A.=1", "=", "A.a"}) {
    EXPECT_EQ(settingsErrorOf([&] { s.set(wrong); }),
              "--set: '" + wrong + "' is not of the form Section.key=value");
  }
}

TEST(Settings, DefaultsFromASecondFileGiveWay) {
  Settings s = Settings::fromText("[A]\na = 1\n", "x.ini");
  s.set("A.b=2");
  const Settings second = Settings::fromText("[a]\nA = 9\nb = 9\nc = 3\n[D]\nd = 4\n", "y.ini");
  EXPECT_EQ(s.mergeDefaults(second), 2u);
  EXPECT_EQ(valueOf(s, "A", "a"), "1");
  EXPECT_EQ(valueOf(s, "A", "b"), "2");
  EXPECT_EQ(valueOf(s, "A", "c"), "3");
  EXPECT_EQ(s.find("D", "d")->origin.file, "y.ini");
  EXPECT_EQ(s.sections(), (std::vector<std::string>{"A", "D"}));
}

}  // namespace
}  // namespace vir
