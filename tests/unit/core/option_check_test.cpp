#include "vir/core/option_check.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "vir/core/choice.h"
#include "vir/core/settings.h"

namespace vir {
namespace {

struct Oven {
  int trays = 3;
  double heat_deg = 180;
  std::string program = "slow";
  std::vector<double> pause_s{1, 2};
};

void describe(OptionVisitor& v, Oven& o) {
  v.section("Oven", "bakes");
  v.value("trays", o.trays, {1, 5}, "how many");
  v.value("heat_deg", o.heat_deg, {50.0, 250.0}, "how hot");
  v.choice("program", o.program, {"slow", "fast"}, "how");
  v.value("pause_s", o.pause_s, 2, "when to look");
}

std::string refusalOf(const Oven& o) {
  try {
    checkBounds(o);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return {};
}

TEST(OptionCheck, TakesWhatTheDeclarationAllows) {
  Oven o;
  EXPECT_EQ(refusalOf(o), "");
  o.trays = 5;
  o.heat_deg = 50;
  o.program = "fast";
  EXPECT_EQ(refusalOf(o), "");
}

TEST(OptionCheck, SaysWhatIsWrongAndWhatIsAllowed) {
  Oven o;
  o.trays = 6;
  EXPECT_EQ(refusalOf(o), "[Oven] trays = 6: out of bounds; allowed: a whole number from 1 to 5");
  o = {};
  o.heat_deg = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusalOf(o).find("[Oven] heat_deg = nan: out of bounds"), std::string::npos);
  o = {};
  o.program = "Slow";
  EXPECT_EQ(refusalOf(o), "[Oven] program = Slow: not one of the choices; allowed: slow, fast");
  o = {};
  o.pause_s = {1, 2, 3};
  EXPECT_NE(refusalOf(o).find("[Oven] pause_s = 1 2 3: 3 numbers; allowed: 2"), std::string::npos);
  o.pause_s = {1, std::numeric_limits<double>::infinity()};
  EXPECT_NE(refusalOf(o).find("not finite"), std::string::npos);
}

enum class Speed { slow, fast };

struct Mixer {
  Speed speed = Speed::slow;
};

void describe(OptionVisitor& v, Mixer& m) {
  v.section("Mixer", "mixes");
  chooseEnum(v, "speed", m.speed, {"slow", "fast"}, "how");
}

TEST(OptionCheck, AnEnumIsAWordInTheFile) {
  const Settings settings = Settings::fromText("[Mixer]\nspeed = FAST\n", "x.ini");
  SettingsReader reader(settings);
  Mixer m;
  describe(reader, m);
  reader.finish();
  EXPECT_EQ(m.speed, Speed::fast);
  EXPECT_NO_THROW(checkBounds(m));
  m.speed = static_cast<Speed>(2);
  try {
    checkBounds(m);
    FAIL() << "2 has no word";
  } catch (const std::invalid_argument& e) {
    EXPECT_STREQ(e.what(), "[Mixer] speed = 2: not one of the choices; allowed: slow, fast");
  }
}

}  // namespace
}  // namespace vir
