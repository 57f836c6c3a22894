/// Differences of ranges (TDoA) as JSON lines.
#include <gtest/gtest.h>

#include "messages.h"
#include "uwb_streams.h"

namespace vir::uwb::test {
namespace {

constexpr const char* kLine = R"({"utime":1500,"uid":9,"ouid":132,"ruid":7,"tdoa":[-2.5]})"
                              "\n";

TEST(JsonDifferences, OfEitherSignAndNone) {
  for (const double difference_m : {-2.5, 0.0, 0.01, 4.25}) {
    emulator::RangeMessage m;
    m.device_time = 1'500'000;
    m.own_id = 9;
    m.items = {{132, difference_m, 7}};
    const Parsed p = parse("json", emulator::encodeJson(m));
    ASSERT_EQ(p.readings.size(), 1u) << difference_m;
    const RangeReading& r = p.readings[0];
    EXPECT_EQ(r.responder, 132);
    EXPECT_EQ(r.reference, 7);
    EXPECT_EQ(r.own, 9);
    EXPECT_EQ(r.range_m, difference_m);
    EXPECT_EQ(r.device_time, 1'500'000);
    EXPECT_EQ(p.counters.failed, 0);
  }
  EXPECT_EQ(parse("json", kLine, 1).readings.size(), 1u);
  EXPECT_EQ(parse("auto", kLine).readings.size(), 1u);
  // Ranges are as ever.
  const Parsed range = parse("json", "{\"ouid\":4,\"raz\":[1.5]}\n");
  ASSERT_EQ(range.readings.size(), 1u);
  EXPECT_FALSE(range.readings[0].reference);
}

TEST(JsonDifferences, WhatWasNotMeasuredAndWhatCannotBe) {
  EXPECT_EQ(parse("json", "{\"ouid\":1,\"ruid\":2,\"tdoa\":[]}\n").counters.failed, 1);
  EXPECT_EQ(parse("json", "{\"ouid\":1,\"ruid\":2,\"tdoa\":[null]}\n").counters.failed, 1);
  for (const char* far : {"301", "-301", "1e300"}) {
    const Parsed p = parse("json", std::string("{\"ouid\":1,\"ruid\":2,\"tdoa\":[") + far + "]}\n");
    EXPECT_EQ(p.counters.implausible, 1) << far;
    EXPECT_TRUE(p.readings.empty()) << far;
  }
}

TEST(JsonDifferences, MalformedLinesAreCorrupt) {
  for (const char* line : {
           R"({"ouid":1,"tdoa":[1]})",             // against which?
           R"({"ruid":1,"tdoa":[1]})",             // of which?
           R"({"ouid":1,"ruid":1,"tdoa":[1]})",    // against itself
           R"({"ouid":1,"ruid":-2,"tdoa":[1]})",   //
           R"({"ouid":1,"ruid":2.5,"tdoa":[1]})",  //
           R"({"ouid":1,"ruid":"2","tdoa":[1]})",  //
           R"({"ouid":1,"ruid":99999999999999999999,"tdoa":[1]})",
           R"({"ouid":1,"ruid":2,"tdoa":1})",              //
           R"({"ouid":1,"ruid":2,"tdoa":["1"]})",          //
           R"({"ouid":1,"ruid":2,"tdoa":[NaN]})",          //
           R"({"ouid":1,"ruid":2,"tdoa":[1],"raz":[1]})",  // which of both?
           R"({"ouid":1,"ruid":2,"ruid":3,"tdoa":[1]})",   //
           R"({"ouid":1,"ruid":2,"tdoa":[1])",             // torn
           R"("ruid":2,"tdoa":[1]})",
       }) {
    const Parsed p = parse("json", std::string("x\n") + line + "\n" + kLine);
    EXPECT_EQ(p.counters.corrupt, 1) << line;
    EXPECT_EQ(p.readings.size(), 1u) << line;
  }
}

}  // namespace
}  // namespace vir::uwb::test
