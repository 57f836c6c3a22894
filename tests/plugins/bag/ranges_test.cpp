/// Ranges of a bag, which have no standard message.
#include <gtest/gtest.h>

#include <limits>

#include "input_error.h"
#include "recording_fixture.h"

namespace vir::bag {
namespace {

/// Two tags on one robot: a topic each, a label each, a place each.
TEST_F(Recording, TagsHaveLabelsAndPlacesOfTheirOwn) {
  {
    test::Ros1Writer bag(path());
    bag.define("some_driver/UwbRange", "Header header\nuint16 anchor_id\nuint32 distance\n");
    for (int i = 0; i < 4; ++i) {
      test::WireBytes m = bag.message();
      m.header(kStart + i * kMs, "").put(std::uint16_t{7}).put(std::uint32_t{2500});
      bag.write(i % 2 == 0 ? "/uwb/tag0" : "/uwb/tag1", "some_driver/UwbRange", m.bytes(),
                kStart + i * kMs);
    }
  }
  options.lever_arm_m = {0.1, 0.2, 0.3, -0.1, -0.2, 0.4};
  const auto all = readAll();
  ASSERT_EQ(all.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::string& label = recording->streams()[static_cast<std::size_t>(all[i].stream)].label;
    EXPECT_EQ(label, i % 2 == 0 ? "UWB0" : "UWB1");
    EXPECT_EQ(std::get<Range>(all[i].what).p_B_U,
              i % 2 == 0 ? Vec3(0.1, 0.2, 0.3) : Vec3(-0.1, -0.2, 0.4));
  }
  options.lever_arm_m = {0.1, 0.2};
  EXPECT_NE(complaint().find("lever_arm_m"), std::string::npos);
}

/// Both in one topic, told by a field.
TEST_F(Recording, TagsInOneTopicHaveLabelsAndPlacesOfTheirOwn) {
  {
    test::Ros1Writer bag(path());
    bag.define("some_driver/UwbRange",
               "Header header\nstring tag\nuint16 anchor\nfloat64 range\n"
               "geometry_msgs/Point tag_offset\n" +
                   std::string(80, '=') +
                   "\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n");
    for (int i = 0; i < 6; ++i) {
      test::WireBytes m = bag.message();
      m.header(kStart + i * kMs, "").text(i % 3 == 0 ? "left" : i % 3 == 1 ? "right" : "top");
      m.put(std::uint16_t{7}).put(2.5).put(0.1 * i).put(0.2).put(0.3);
      bag.write("/uwb", "some_driver/UwbRange", m.bytes(), kStart + i * kMs);
    }
  }
  const auto all = readAll();
  ASSERT_EQ(all.size(), 6u);
  EXPECT_EQ(all[0].label, "");
  EXPECT_EQ(all[1].label, "UWB1");
  EXPECT_EQ(all[5].label, "UWB2");
  EXPECT_EQ(std::get<Range>(all[4].what).p_B_U, Vec3(0.1 * 4, 0.2, 0.3));
  EXPECT_TRUE(noted("tag right is labelled UWB1"));
  options.lever_arm_m = {0, 0, 0, 1, 2, 3, 4, 5, 6};
  options.topics = "range=/uwb:anchor,range,tag=tag";
  EXPECT_EQ(std::get<Range>(readAll()[4].what).p_B_U, Vec3(1, 2, 3));
  options.topics = "range=/uwb:anchor,range,tag=no_such";
  readAll();
  EXPECT_TRUE(noted("no_such") || complaint().find("no_such") != std::string::npos);
}

/// NTU VIRAL's messages tell where an anchor is, or 99999; other types by the name of the field.
TEST_F(Recording, PlacesOfAnchorsAreThoseThatStay) {
  const std::string point =
      std::string(80, '=') + "\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n";
  {
    test::Ros1Writer bag(path());
    bag.define("uwb_driver/UwbRange",
               "Header header\nuint8 responder_id\nfloat32 distance\n"
               "geometry_msgs/Point responder_location\n" +
                   point);
    bag.define(
        "other/UwbDistance",
        "Header header\nuint16 anchor\nfloat64 range\ngeometry_msgs/Point anchor_position\n" +
            point);
    for (int i = 0; i < 8; ++i) {
      test::WireBytes m = bag.message();
      m.header(kStart + i * kMs, "").put(static_cast<std::uint8_t>(100 + i % 2)).put(2.5F);
      m.put(i % 2 == 0 ? 5.0 : 99999.0).put(i % 2 == 0 ? -1.0 : 99999.0).put(99999.0 * (i % 2));
      bag.write("/uwb", "uwb_driver/UwbRange", m.bytes(), kStart + i * kMs);
      test::WireBytes other = bag.message();
      other.header(kStart + i * kMs, "").put(static_cast<std::uint16_t>(i % 2)).put(3.5);
      other.put(i % 2 == 0 ? 0.5 : 0.5 * i).put(2.0).put(3.0);
      bag.write("/other", "other/UwbDistance", other.bytes(), kStart + i * kMs);
    }
  }
  EXPECT_EQ(readAll().size(), 16u);
  const std::vector<SurveyedAnchor> standing = recording->anchorPlaces().standing();
  ASSERT_EQ(standing.size(), 2u);
  EXPECT_EQ(standing[0].id, 0u);
  EXPECT_EQ(standing[0].p_S, Vec3(0.5, 2, 3));
  EXPECT_EQ(standing[1].id, 100u);
  EXPECT_EQ(standing[1].p_S, Vec3(5, -1, 0));
  options.topics = "range=/other:anchor,range,place=anchor_position";
  readAll();
  EXPECT_EQ(recording->anchorPlaces().standing().size(), 1u);
  options.topics = "range=/other:anchor,range,place=no_such";
  readAll();
  EXPECT_TRUE(noted("no_such"));
}

TEST_F(Recording, RangesOfATypeNobodyKnowsByTheNamesOfItsFields) {
  {
    test::Ros1Writer bag(path());
    bag.define("some_driver/UwbRange", "Header header\nuint16 anchor_id\nuint32 distance\n");
    bag.define("other/UwbScan",
               "Header header\nMeasurement[] all\n" + std::string(80, '=') +
                   "\nMSG: other/Measurement\nstring anchor_name\nfloat64 range_m\n");
    bag.define("cf_msgs/Tdoa", "Header header\nint32 idA\nint32 idB\nfloat32 data\n");
    test::WireBytes one = bag.message();
    one.header(kStart, "tag").put(std::uint16_t{7}).put(std::uint32_t{2500});
    bag.write("/a", "some_driver/UwbRange", one.bytes(), kStart);
    test::WireBytes list = bag.message();
    list.header(kStart + kMs, "tag").put(std::uint32_t{1}).text("0x84").put(3.5);
    bag.write("/b", "other/UwbScan", list.bytes(), kStart + kMs);
    test::WireBytes difference = bag.message();
    difference.header(kStart + 2 * kMs, "tag").put(1).put(2).put(-0.5F);
    bag.write("/tdoa", "cf_msgs/Tdoa", difference.bytes(), kStart + 2 * kMs);
  }
  const auto ranges = only<Range>(readAll());
  ASSERT_EQ(ranges.size(), 3u);
  EXPECT_EQ(ranges[2].anchor, 2u);
  ASSERT_TRUE(ranges[2].reference);
  EXPECT_EQ(*ranges[2].reference, 1u);
  EXPECT_EQ(ranges[2].range_m, -0.5);
  EXPECT_EQ(ranges[2].t, kStart + 2 * kMs);
  EXPECT_FALSE(ranges[0].reference);
  EXPECT_EQ(ranges[0].anchor, 7u);
  EXPECT_EQ(ranges[0].range_m, 2.5);  // whole numbers are millimetres
  EXPECT_EQ(ranges[1].anchor, 0x84u);
  EXPECT_EQ(ranges[1].range_m, 3.5);
  EXPECT_TRUE(noted("by the names of its fields, anchor_id,distance,unit=mm"));
  EXPECT_TRUE(noted("/tdoa (cf_msgs/Tdoa) taken as range, TDOA"));
}

TEST_F(Recording, RangesByTheNamesOfTheirFields) {
  {
    test::Ros1Writer bag(path());
    bag.define("my/Range", "time when\nuint64 who\nfloat64 cm\nfloat32 sd\n");
    bag.define("nlink_parser/LinktrackNodeframe3",
               "uint8 role\nuint8 id\nuint32 local_time\nuint32 system_time\nfloat32 voltage\n"
               "LinktrackNode2[] nodes\n===\nMSG: nlink_parser/LinktrackNode2\nuint8 role\n"
               "uint8 id\nfloat32 dis\nfloat32 fp_rssi\nfloat32 rx_rssi\n");
    test::WireBytes m = bag.message();
    m.put(std::uint32_t{1'600'000'001}).put(std::uint32_t{5});
    m.put(std::uint64_t{0xDECA0123456789AB}).put(250.0).put(0.5f);
    bag.write("/r", "my/Range", m.bytes(), kStart);
    test::WireBytes n = bag.message();
    n.put(std::uint8_t{0}).put(std::uint8_t{9}).put(0u).put(0u).put(5.f).put(2u);
    for (int i = 0; i < 2; ++i) {
      n.put(std::uint8_t{1}).put(static_cast<std::uint8_t>(3 + i)).put(1.5f + i).put(0.f).put(0.f);
    }
    bag.write("/nodes", "nlink_parser/LinktrackNodeframe3", n.bytes(), kStart);
  }
  auto ranges = only<Range>(readAll("range=/r:who,cm,unit=cm,stamp=when,sigma=sd"));
  ASSERT_EQ(ranges.size(), 1u);
  EXPECT_EQ(ranges[0].range_m, 2.5);
  EXPECT_EQ(ranges[0].sigma_m, 0.5);
  EXPECT_EQ(ranges[0].t, 1'600'000'001LL * 1'000 * kMs + 5);
  EXPECT_EQ(ranges[0].anchor, 1'000'000u);
  EXPECT_EQ(recording->anchors().mapped().begin()->first,
            std::to_string(std::uint64_t{0xDECA0123456789AB}));
  EXPECT_TRUE(noted("has the number 1000000"));
  ranges = only<Range>(readAll("range=/nodes"));
  ASSERT_EQ(ranges.size(), 2u);
  EXPECT_EQ(ranges[1].anchor, 4u);
  EXPECT_EQ(ranges[1].range_m, 2.5);
  EXPECT_EQ(ranges[1].t, kStart);  // no stamp: as received
}

TEST_F(Recording, RangesOfPackagesNamedUwbMsgsAreFoundByTheNamesOfTheirFields) {
  {
    test::Ros1Writer bag(path());
    // One message a range, without a header.
    bag.define("uwb_msgs/Range",
               "time stamp\nstring anchorid\nstring listenerid\nbool valid_range\n"
               "float32 distance\n");
    for (const bool valid : {true, false}) {
      test::WireBytes m = bag.message();
      m.put(std::uint32_t{1'600'000'001}).put(std::uint32_t{7}).text("anchor_2").text("tag");
      m.put(static_cast<std::uint8_t>(valid)).put(3.25f);
      bag.write("/uwb", "uwb_msgs/Range", m.bytes(), kStart);
    }
    // Two lists side by side, anchors by name.
    bag.define("uwb_msgs/Ranges",
               "Header header\nstring mobile\nstring[] anchors\nfloat64[] data\n===\n"
               "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n");
    test::WireBytes n = bag.message();
    n.put(0u).put(std::uint32_t{1'600'000'002}).put(0u).text("").text("tag").put(2u);
    n.text("anchor_2").text("0x10").put(2u).put(1.5).put(2.5);
    bag.write("/uwb/all", "uwb_msgs/Ranges", n.bytes(), kStart);
  }
  const auto ranges = only<Range>(readAll());
  ASSERT_EQ(ranges.size(), 3u);
  EXPECT_EQ(ranges[0].range_m, 3.25);
  EXPECT_EQ(ranges[0].t, 1'600'000'001LL * 1'000 * kMs + 7);
  EXPECT_EQ(ranges[1].range_m, 1.5);
  EXPECT_EQ(ranges[1].anchor, ranges[0].anchor);  // the same name
  EXPECT_EQ(ranges[2].range_m, 2.5);
  EXPECT_EQ(ranges[2].anchor, 16u);
  EXPECT_TRUE(noted("anchorid,distance,stamp=stamp,valid=valid_range"));
  EXPECT_TRUE(noted("by the names of its fields, anchors,data"));
}

/// Without a header, of a type nobody knows, and by the fields that the user names.
TEST_F(Recording, DifferencesOfRanges) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  {
    test::Ros1Writer bag(path());
    bag.define("cf_msgs/Tdoa", "time stamp\nint8 idA\nint8 idB\nfloat32 data\n");
    struct Row {
      std::uint8_t a, b;
      float d;
    };
    const Row rows[] = {{1, 2, 1.25F}, {2, 3, nan}, {3, 3, 0.5F}, {0, 1, 0.F}};
    std::uint32_t s = 1'600'000'001;
    for (const Row& r : rows) {
      bag.write("/tdoa_data", "cf_msgs/Tdoa",
                bag.message().put(s++).put(5u).put(r.a).put(r.b).put(r.d).bytes(), kStart);
    }
    bag.define("other/Tdoa", "Header header\nstring anchor_a\nstring anchor_b\nfloat64 diff\n");
    test::WireBytes guessed = bag.message();
    guessed.header(kStart + kMs, "tag").text("0x10").text("0x11").put(-2.5);
    bag.write("/b", "other/Tdoa", guessed.bytes(), kStart + kMs);
    bag.define("my/Pair", "Header header\nuint8 base\nuint8 far\nfloat64 mm\n");
    test::WireBytes named = bag.message();
    named.header(kStart + 2 * kMs, "tag").put(std::uint8_t{4}).put(std::uint8_t{5}).put(-750.0);
    bag.write("/c", "my/Pair", named.bytes(), kStart + 2 * kMs);
  }
  auto ranges = only<Range>(readAll());
  ASSERT_EQ(ranges.size(), 3u);
  const auto isDifference = [](const Range& r, std::uint64_t reference, std::uint64_t anchor) {
    return r.reference == reference && r.anchor == anchor;
  };
  int known = 0, zero = 0, guessed = 0;
  for (const Range& r : ranges) {
    if (isDifference(r, 1, 2)) {
      ++known;
      EXPECT_EQ(r.range_m, 1.25);
      EXPECT_EQ(r.t, 1'600'000'001LL * 1'000 * kMs + 5);
    }
    zero += isDifference(r, 0, 1) && r.range_m == 0;
    guessed += isDifference(r, 0x10, 0x11) && r.range_m == -2.5;
  }
  EXPECT_EQ(known, 1);
  EXPECT_EQ(zero, 1);
  EXPECT_EQ(guessed, 1);
  EXPECT_EQ(log.get("range_not_finite"), 1);
  EXPECT_EQ(log.get("range_implausible"), 1) << "of one anchor to itself";
  EXPECT_TRUE(noted("anchor_b,diff,reference=anchor_a"));
  ranges = only<Range>(readAll("range=/c:far,mm,unit=mm,reference=base"));
  ASSERT_EQ(ranges.size(), 1u);
  EXPECT_TRUE(isDifference(ranges[0], 4, 5));
  EXPECT_EQ(ranges[0].range_m, -0.75);
}

TEST_F(Recording, FieldsThatAreAskedForAndNotThereAreSaid) {
  {
    test::Ros1Writer bag(path());
    bag.define("my/Scan", "my/One[] ranges\n===\nMSG: my/One\nuint8 id\nfloat32 d\nbool ok\n");
    test::WireBytes m = bag.message();
    m.put(2u);
    for (const bool ok : {true, false}) {
      m.put(std::uint8_t{4}).put(1.5f).put(static_cast<std::uint8_t>(ok));
    }
    bag.write("/r", "my/Scan", m.bytes(), kStart);
  }
  const std::string fields = "range=/r:ranges[].id,ranges[].d";
  EXPECT_EQ(only<Range>(readAll(fields)).size(), 2u);
  EXPECT_EQ(only<Range>(readAll(fields + ",valid=ok")).size(), 1u);
  EXPECT_EQ(only<Range>(readAll(fields + ",valid=ranges[].ok")).size(), 1u);
  for (const char* wrong : {",valid=nonsense", ",stamp=nonsense", ",sigma=nonsense"}) {
    EXPECT_EQ(only<Range>(readAll(fields + wrong)).size(), 0u) << wrong;
    EXPECT_EQ(log.get("undecodable_UWB0"), 1) << wrong;
    EXPECT_TRUE(noted("nonsense")) << wrong;
  }
}

TEST_F(Recording, ATopicThatSpeaksOfRangesAndIsNotUnderstoodIsSaid) {
  {
    test::Ros1Writer bag(path());
    bag.define("acme/UwbScan", "acme/One[] found\n===\nMSG: acme/One\nuint8 who\nfloat32 how\n");
    bag.write("/scan", "acme/UwbScan", bag.message().put(0u).bytes(), kStart);
    test::writeImu(bag, "/imu", kStart, kStart, {0, 0, 0}, {0, 0, 9.81});
  }
  readAll();
  EXPECT_TRUE(noted("/scan (acme/UwbScan) left out: it speaks of ranges"));
}

TEST_F(Recording, ATopicThatBeginsLateIsSaid) {
  {
    test::Ros1Writer bag(path());
    bag.define("my/Range", "uint8 anchor_id\nfloat32 range\n");
    for (int k = 0; k < 200; ++k) {
      const TimeNs t = kStart + 100 * k * kMs;
      test::writeImu(bag, "/imu", t, t, {0, 0, 0}, {0, 0, 9.81});
      if (k < 150) continue;
      bag.write("/uwb", "my/Range", bag.message().put(std::uint8_t{4}).put(1.5f).bytes(), t);
    }
  }
  EXPECT_EQ(only<Range>(readAll()).size(), 0u);
  EXPECT_TRUE(noted("/uwb (my/Range) left out: it begins after the first 10 s"));
  options.first_look_s = 0;
  EXPECT_EQ(only<Range>(readAll()).size(), 50u);
}

}  // namespace
}  // namespace vir::bag
