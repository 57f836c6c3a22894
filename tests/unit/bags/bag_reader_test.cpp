/// Bags of other writers, whole, cut off at every byte, and damaged.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "bag_fixtures.h"
#include "vir_test_bag_writer.h"
#include "vir_test_temp_folder.h"

namespace vir::bags {
namespace {

using test::allBags;
using test::bytesOf;
using test::fixture;
using test::Kept;
using test::kStart;
using test::readAll;

class EveryBag : public testing::TestWithParam<std::string> {};

TEST_P(EveryBag, GivesAllMessagesWithTheirTimes) {
  const auto reader = openBag(fixture(GetParam()));
  const std::vector<Kept> messages = readAll(*reader);
  EXPECT_TRUE(reader->damage().empty()) << reader->damage().front();
  EXPECT_EQ(reader->progress(), 1);
  std::map<std::string, int> counts;
  std::map<std::string, std::string> types;
  for (const Kept& m : messages) {
    ++counts[m.channel.topic];
    types[m.channel.topic] = m.channel.type;
  }
  const std::map<std::string, int> expected = {
      {"/cam0/camera_info", 1}, {"/tf_static", 1}, {"/cam0/image_raw", 8}, {"/imu0", 80},
      {"/vicon/body", 40},      {"/uwb", 10},      {"/my_ranges", 4}};
  EXPECT_EQ(counts, expected);
  EXPECT_EQ(types["/tf_static"], "tf2_msgs/TFMessage");
  EXPECT_EQ(messages.front().received, kStart + 3'000'000);
  for (std::size_t i = 1; i < messages.size(); ++i) {
    EXPECT_LE(messages[i - 1].received, messages[i].received);
  }
}

TEST_P(EveryBag, FieldsAreWhatTheWriterPutIn) {
  const auto reader = openBag(fixture(GetParam()));
  std::map<std::string, int> number;
  for (const Kept& k : readAll(*reader)) {
    const int i = number[k.channel.topic]++;
    if (k.channel.topic == "/my_ranges" || k.channel.topic == "/uwb") continue;
    const auto definition = Definition::of(k.channel);
    const MessageView m(*definition, {k.data.data(), k.data.size()});
    if (k.channel.topic == "/imu0") {
      EXPECT_EQ(m.time("header.stamp"), kStart + i * 5'000'000LL);
      EXPECT_EQ(m.text("header.frame_id"), "imu");
      EXPECT_EQ(m.number("angular_velocity.x"), 0.01 * i);
      EXPECT_EQ(m.number("angular_velocity.y"), -0.02 * i);
      EXPECT_EQ(m.number("linear_acceleration.x"), 0.1 * i);
      EXPECT_EQ(m.number("linear_acceleration.z"), 9.81);
      EXPECT_EQ(m.numbers("linear_acceleration_covariance", 9), std::vector<double>(9, 0.0));
    } else if (k.channel.topic == "/cam0/image_raw") {
      EXPECT_EQ(m.integer("width"), 32);
      EXPECT_EQ(m.integer("height"), 24);
      EXPECT_EQ(m.text("encoding"), "mono8");
      const ByteView pixels = m.bytes("data");
      ASSERT_EQ(pixels.size, 32u * 24);
      for (int y = 0; y < 24; ++y) {
        for (int x = 0; x < 32; ++x) {
          ASSERT_EQ(pixels.data[y * 32 + x], (3 * x + 5 * y + 7 * i) & 255);
        }
      }
    } else if (k.channel.topic == "/vicon/body") {
      EXPECT_EQ(m.text("child_frame_id"), "base");
      EXPECT_EQ(m.number("transform.translation.x"), 0.01 * i);
      EXPECT_EQ(m.number("transform.rotation.w"), 1);
    } else if (k.channel.topic == "/tf_static") {
      std::vector<std::string> children;
      m.each("transforms",
             [&](const MessageView& t) { children.emplace_back(t.text("child_frame_id")); });
      EXPECT_EQ(children, (std::vector<std::string>{"imu", "cam"}));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Fixtures, EveryBag, testing::ValuesIn(allBags()), [](const auto& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

TEST(BagReader, OwnTypesAreReadByTheirDescription) {
  for (const char* bag : {"ros1_lz4.bag", "ros2_lz4.mcap", "ros2_split"}) {
    int uwb = 0, own = 0;
    const auto reader = openBag(fixture(bag));
    for (const Kept& k : readAll(*reader)) {
      if (k.channel.topic != "/my_ranges" && k.channel.topic != "/uwb") continue;
      const auto definition = Definition::of(k.channel);
      const MessageView m(*definition, {k.data.data(), k.data.size()});
      if (k.channel.topic == "/uwb") {
        EXPECT_EQ(m.number("range"), 2.5 + 0.125 * uwb) << bag;
        EXPECT_EQ(m.integer("to_id"), uwb % 3) << bag;
        ++uwb;
        continue;
      }
      std::string anchors;
      std::vector<double> mm;
      m.each("ranges", [&](const MessageView& r) {
        anchors += std::string(r.text("anchor")) + " ";
        mm.push_back(r.number("mm"));
      });
      EXPECT_EQ(anchors, "0x84 0x85 ") << bag;
      EXPECT_EQ(mm, (std::vector<double>{1000.0 + own, 2000.0 + own})) << bag;
      ++own;
    }
    EXPECT_EQ(uwb, 10) << bag;
    EXPECT_EQ(own, 4) << bag;
  }
}

TEST(BagReader, AnUnknownTypeWithoutDescriptionSaysWhatToDo) {
  const auto reader = openBag(fixture("ros2_foxy.db3"));
  BagMessage m;
  while (reader->next(&m) && m.channel->topic != "/uwb") {
  }
  try {
    Definition::of(*m.channel);
    FAIL() << "no complaint";
  } catch (const BagError& e) {
    EXPECT_NE(std::string(e.what()).find("/uwb"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("Iron"), std::string::npos) << e.what();
  }
}

/// However it is cut: no harm, what comes is a beginning of what is in the whole file, and it is
/// said that something is missing.
void cutEverywhere(const std::string& name, std::size_t step) {
  const Bytes whole = bytesOf(fixture(name));
  const std::vector<Kept> all = readAll(*openBag({whole.data(), whole.size()}, name));
  ASSERT_GT(all.size(), 100u);
  std::size_t most = 0;
  for (std::size_t size = 0; size < whole.size(); size += step) {
    // Bytes of its own, so that reading beyond their end is noticed.
    const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    std::vector<Kept> got;
    bool told = false;
    try {
      const auto reader = openBag({part.data(), part.size()}, name);
      got = readAll(*reader);
      told = !reader->damage().empty();
    } catch (const BagError&) {
      told = true;
    }
    ASSERT_LE(got.size(), all.size());
    // Between two records of a ROS 1 bag nothing shows that more was to come.
    const bool ros1 = name.find(".bag") != std::string::npos;
    ASSERT_TRUE(told || ros1 || got.size() == all.size()) << size;
    for (std::size_t i = 0; i < got.size(); ++i) {
      ASSERT_EQ(got[i].received, all[i].received) << size;
      ASSERT_TRUE(got[i].data == all[i].data) << name << " cut at " << size << ", message " << i;
    }
    most = std::max(most, got.size());
  }
  EXPECT_GT(most, all.size() / 2) << name << ": cut bags give too little";
}

TEST(CutBag, Ros1None) { cutEverywhere("ros1_none.bag", 1); }
TEST(CutBag, Ros1Bz2) { cutEverywhere("ros1_bz2.bag", 5); }
TEST(CutBag, Ros1Lz4) { cutEverywhere("ros1_lz4.bag", 1); }
TEST(CutBag, McapNone) { cutEverywhere("ros2_none.mcap", 1); }
TEST(CutBag, McapBare) { cutEverywhere("ros2_bare.mcap", 1); }
TEST(CutBag, McapLz4) { cutEverywhere("ros2_lz4.mcap", 1); }
TEST(CutBag, McapZstd) { cutEverywhere("ros2_zstd.mcap", 1); }
TEST(CutBag, Sqlite) { cutEverywhere("ros2_foxy.db3", 1); }
TEST(CutBag, SqliteOfPackedMessages) { cutEverywhere("ros2_message_zstd/packed_0.db3", 1); }

/// A file that was compressed as a whole: each part of it gives a beginning of the messages.
TEST(CutBag, PackedFile) {
  const Bytes whole = bytesOf(fixture("ros2_file_zstd/whole_0.db3.zstd"));
  const std::size_t all = readAll(*openBag(fixture("ros2_file_zstd/whole_0.db3.zstd"))).size();
  const vir::test::TempFolder folder;
  const std::string path = (folder / "cut.db3.zstd").string();
  for (std::size_t n = 0; n < whole.size(); ++n) {
    vir::test::writeText(path, std::string(whole.begin(), whole.begin() + static_cast<long>(n)));
    bool told = false;
    std::size_t got = 0;
    try {
      const auto reader = openBag(path);
      got = readAll(*reader).size();
      told = !reader->damage().empty();
    } catch (const BagError&) {
      told = true;
    }
    ASSERT_TRUE(told) << n;
    ASSERT_LE(got, all) << n;
  }
}

TEST(DamagedBag, AChunkWithAWrongChecksumIsLeftOut) {
  Bytes bytes = bytesOf(fixture("ros2_none.mcap"));
  const std::string mark = "mono8";
  const auto at = std::search(bytes.begin(), bytes.end(), mark.begin(), mark.end());
  ASSERT_NE(at, bytes.end());
  *(at + 100) ^= 1;
  const auto reader = openBag({bytes.data(), bytes.size()}, "x.mcap");
  const std::size_t n = readAll(*reader).size();
  EXPECT_LT(n, 144u);
  EXPECT_GT(n, 100u);
  ASSERT_EQ(reader->damage().size(), 1u);
  EXPECT_NE(reader->damage()[0].find("checksum"), std::string::npos) << reader->damage()[0];
}

TEST(DamagedBag, SizesThatAreLiesCostNothing) {
  // A chunk that claims a gigabyte, and one that claims more than the file has.
  for (const std::uint32_t claimed : {0x3FFFFFFFu, 0xFFFFFFFFu}) {
    Bytes bytes = bytesOf(fixture("ros1_lz4.bag"));
    const std::string mark = "size=";
    const auto at = std::search(bytes.begin(), bytes.end(), mark.begin(), mark.end());
    ASSERT_NE(at, bytes.end());
    for (int i = 0; i < 4; ++i) *(at + 5 + i) = static_cast<std::uint8_t>(claimed >> (8 * i));
    const auto reader = openBag({bytes.data(), bytes.size()}, "x.bag");
    readAll(*reader);
    EXPECT_FALSE(reader->damage().empty());
  }
}

/// The difference of any two times must fit, whatever the file says.
TEST(DamagedBag, TimesAtTheEndsOfWhatANumberHolds) {
  const Bytes whole = bytesOf(fixture("ros2_bare.mcap"));
  const std::vector<Kept> all = readAll(*openBag({whole.data(), whole.size()}, "x.mcap"));
  Bytes time(8);
  for (std::size_t i = 0; i < 8; ++i) {
    time[i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(all[5].received) >> (8 * i));
  }
  for (const int top : {0x7F, 0x80}) {
    Bytes bytes = whole;
    const auto at = std::search(bytes.begin(), bytes.end(), time.begin(), time.end());
    ASSERT_NE(at, bytes.end());
    std::fill(at, at + 7, static_cast<std::uint8_t>(top == 0x7F ? 0xFF : 0));
    *(at + 7) = static_cast<std::uint8_t>(top);
    TimeNs low = 0, high = 0, apart = 0;
    for (const Kept& k : readAll(*openBag({bytes.data(), bytes.size()}, "x.mcap"))) {
      low = std::min(low, k.received);
      high = std::max(high, k.received);
    }
    EXPECT_TRUE(top == 0x7F ? high > INT64_MAX / 4 : low < -(INT64_MAX / 4));
    EXPECT_FALSE(__builtin_sub_overflow(high, low, &apart));
  }
}

TEST(DamagedBag, FlippedBitsDoNoHarm) {
  std::uint32_t random = 12345;
  const auto next = [&] { return random = random * 1664525u + 1013904223u; };
  for (const char* name :
       {"ros1_none.bag", "ros1_bz2.bag", "ros2_zstd.mcap", "ros2_bare.mcap", "ros2_foxy.db3"}) {
    const Bytes whole = bytesOf(fixture(name));
    for (int round = 0; round < 400; ++round) {
      Bytes bytes = whole;
      for (int i = 0; i < 4; ++i) bytes[next() % bytes.size()] ^= 1u << (next() >> 16) % 8;
      try {
        const auto reader = openBag({bytes.data(), bytes.size()}, name);
        for (const Kept& k : readAll(*reader)) {
          const auto definition = Definition::of(k.channel);
          const MessageView m(*definition, {k.data.data(), k.data.size()});
          for (const Field& f : m.type().fields) {
            if (f.type != nullptr && f.array) m.each(f.name, [](const MessageView&) {});
          }
        }
      } catch (const BagError&) {
      }
    }
  }
}

TEST(BagKind, ByContent) {
  EXPECT_EQ(bagKindOf(fixture("ros1_bz2.bag")), BagKind::ros1);
  EXPECT_EQ(bagKindOf(fixture("ros2_bare.mcap")), BagKind::mcap);
  EXPECT_EQ(bagKindOf(fixture("ros2_foxy.db3")), BagKind::sqlite);
  EXPECT_EQ(bagKindOf(fixture("ros2_split")), BagKind::folder);
  EXPECT_EQ(bagKindOf(fixture("ros2_file_zstd")), BagKind::folder);
  EXPECT_EQ(bagKindOf(fixture("ros2_file_zstd/whole_0.db3.zstd")), BagKind::sqlite);
  EXPECT_EQ(bagKindOf(fixture("make_db3.py")), BagKind::none);
  EXPECT_EQ(bagKindOf(fixture("")), BagKind::folder);  // it holds .mcap files
  EXPECT_EQ(bagKindOf("/nowhere"), BagKind::none);
}

/// `n` readings a hundredth of a second apart.
void writePart(const std::filesystem::path& path, TimeNs from, int n, const std::string& topic) {
  vir::test::Ros1Writer bag(path.string());
  for (int i = 0; i < n; ++i) {
    const TimeNs t = from + i * 10'000'000;
    vir::test::writeImu(bag, topic, t, t, {0, 0, 0}, {0, 0, 9.81});
  }
}

TEST(SplitBag, PartsInAFolderAreOneRecording) {
  const vir::test::TempFolder folder;
  // Not in the order of the names: part 10 is behind part 9.
  for (const int part : {0, 9, 10}) {
    writePart(folder / ("flight_" + std::to_string(part) + ".bag"),
              kStart + part * 3'600'000'000'000, 20, "/imu");
  }
  writePart(folder / "flight_11.bag.active", kStart + 11 * 3'600'000'000'000, 5, "/imu");
  EXPECT_EQ(bagKindOf(folder.path().string()), BagKind::ros1_folder);
  const auto reader = openBag(folder.path().string());
  const std::vector<Kept> messages = readAll(*reader);
  ASSERT_EQ(messages.size(), 65u);
  for (std::size_t i = 1; i < messages.size(); ++i) {
    EXPECT_LT(messages[i - 1].received, messages[i].received);
  }
  EXPECT_EQ(reader->progress(), 1);
}

TEST(SplitBag, RecordersSideBySideAreMerged) {
  const vir::test::TempFolder folder;
  writePart(folder / "camera.bag", kStart + 5'000'000, 20, "/a");
  writePart(folder / "imu.bag", kStart, 20, "/b");
  const std::vector<Kept> messages = readAll(*openBag(folder.path().string()));
  ASSERT_EQ(messages.size(), 40u);
  EXPECT_EQ(messages[0].channel.topic, "/b");
  EXPECT_EQ(messages[1].channel.topic, "/a");
}

TEST(SplitBag, SeveralRecordingsAreNotOne) {
  const vir::test::TempFolder folder;
  writePart(folder / "hall.bag", kStart, 20, "/imu");
  writePart(folder / "garden.bag", kStart + 3'600'000'000'000, 20, "/imu");
  try {
    openBag(folder.path().string());
    FAIL();
  } catch (const BagError& e) {
    EXPECT_NE(std::string(e.what()).find("several recordings"), std::string::npos) << e.what();
  }
}

TEST(BagFolder, WithoutMetadataFilesComeInTheOrderOfTheirNumbers) {
  vir::test::TempFolder folder;
  namespace fs = std::filesystem;
  fs::copy_file(fixture("ros2_split/split_0.db3"), folder / "a_9.db3");
  fs::copy_file(fixture("ros2_split/split_1.db3"), folder / "a_10.db3");
  const auto reader = openBag((folder / "").string());
  const auto messages = readAll(*reader);
  ASSERT_EQ(messages.size(), 144u);
  for (std::size_t i = 1; i < messages.size(); ++i) {
    EXPECT_LE(messages[i - 1].received, messages[i].received);
  }
  ASSERT_EQ(reader->damage().size(), 1u);
  EXPECT_NE(reader->damage()[0].find("metadata.yaml"), std::string::npos);
}

TEST(BagFolder, APartThatIsMissingIsSaid) {
  vir::test::TempFolder folder;
  namespace fs = std::filesystem;
  fs::copy_file(fixture("ros2_split/split_1.db3"), folder / "split_1.db3");
  fs::copy_file(fixture("ros2_split/metadata.yaml"), folder / "metadata.yaml");
  const auto reader = openBag((folder / "").string());
  EXPECT_EQ(readAll(*reader).size(), 72u);
  ASSERT_EQ(reader->damage().size(), 1u);
  EXPECT_NE(reader->damage()[0].find("split_0.db3"), std::string::npos) << reader->damage()[0];
}

TEST(BagReader, ABagWithoutAnIndexIsSaidToBeOne) {
  for (const char* name : {"ros1_unindexed.bag", "ros1_lz4.bag", "ros1_none.bag"}) {
    const auto reader = openBag(fixture(name));
    BagMessage message;
    while (reader->next(&message)) continue;
    EXPECT_TRUE(reader->damage().empty()) << name;
    const bool unindexed = name == std::string("ros1_unindexed.bag");
    ASSERT_EQ(reader->notes().size(), unindexed ? 1u : 0u) << name;
    if (!unindexed) continue;
    EXPECT_NE(reader->notes()[0].find("has no index"), std::string::npos) << reader->notes()[0];
  }
}

}  // namespace
}  // namespace vir::bags
