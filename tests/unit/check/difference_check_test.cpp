#include "vir/check/difference_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "found.h"

namespace vir::check {
namespace {

GivenAnchors places() {
  GivenAnchors out;
  out.survey = {{1, Vec3(0, 0, 2), 0.02}, {2, Vec3(8, 0, 2), 0.02}};
  return out;
}

Range difference(int i, double m) {
  Range r;
  r.t = i * 50000000LL;
  r.anchor = 2;
  r.reference = 1;
  r.range_m = m;
  r.sigma_m = 0.07;
  return r;
}

Kinds kindsOf(double scale, const GivenAnchors& given) {
  DifferenceCheck check;
  for (int i = 0; i < 400; ++i) check.add(difference(i, scale * 6 * std::sin(0.02 * i)));
  return seriousKinds(check.findings(given));
}

TEST(DifferenceCheck, NamesTheUnitAndWhatCannotBe) {
  EXPECT_EQ(kindsOf(1, places()), Kinds{});
  EXPECT_EQ(kindsOf(1000, places()), Kinds{"differences_in_mm"});
  EXPECT_EQ(kindsOf(2, places()), Kinds{"difference_impossible"});
  EXPECT_EQ(kindsOf(2, {}), Kinds{}) << "nobody says where the anchors are";
}

TEST(DifferenceCheck, NamesWhatIsNone) {
  DifferenceCheck check;
  EXPECT_TRUE(check.findings({}).empty());
  for (int i = 0; i < 100; ++i) check.add(difference(i, std::numeric_limits<double>::quiet_NaN()));
  const std::vector<Finding> all = check.findings({});
  EXPECT_EQ(worst(all), Severity::unusable);
  EXPECT_EQ(seriousKinds(all), Kinds{"differences_unusable"});
}

TEST(DifferenceCheck, SaysThatTheirAnchorsPlacesAreNeeded) {
  DifferenceCheck check;
  for (int i = 0; i < 100; ++i) check.add(difference(i, 0.01 * i));
  const std::vector<Finding> all = check.findings({});
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].severity, Severity::note);
  EXPECT_NE(all[0].remedy.find("--anchors"), std::string::npos);
}

}  // namespace
}  // namespace vir::check
