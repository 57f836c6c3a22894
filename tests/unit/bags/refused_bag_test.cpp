/// What is no bag is said, and a bag that cannot be written whole does not get its name.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <string>

#include "vir/bags/bag_reader.h"
#include "vir/bags/mcap_writer.h"
#include "vir_test_temp_folder.h"

namespace vir::bags {
namespace {

template <typename Work>
std::string refusalOf(Work work) {
  try {
    work();
  } catch (const BagError& e) {
    return e.what();
  }
  return "not refused";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != text.npos;
}

std::string littleEndian(std::uint32_t v) {
  std::string out;
  for (int i = 0; i < 4; ++i) out += static_cast<char>(static_cast<unsigned char>(v >> (8 * i)));
  return out;
}

TEST(RefusedBag, WhatIsNoneOrIsNotThere) {
  const test::TempFolder folder;
  const std::string path = (folder / "a.bag").string();
  const std::string missing = refusalOf([&] { openBag(path); });
  EXPECT_TRUE(contains(missing, path)) << missing;
  test::writeText(path, "t,x,y,z\n1,2,3,4\n");
  const std::string why = refusalOf([&] { openBag(path); });
  EXPECT_TRUE(contains(why, path) && contains(why, "is no ROS 1 bag, MCAP file or ROS 2 bag"))
      << why;
}

TEST(RefusedBag, AnEncryptedOneIsSaidToBe) {
  const auto field = [](const std::string& text) {
    return littleEndian(static_cast<std::uint32_t>(text.size())) + text;
  };
  const std::string header =
      field(std::string("op=\x03")) + field("encryptor=rosbag/AesCbcEncryptor");
  const test::TempFolder folder;
  const std::string path = (folder / "a.bag").string();
  test::writeText(path, "#ROSBAG V2.0\n" + field(header) + field(std::string(64, ' ')));
  const std::string why = refusalOf([&] {
    BagMessage message;
    const auto bag = openBag(path);
    while (bag->next(&message)) {
    }
  });
  EXPECT_TRUE(contains(why, path + ": is encrypted")) << why;
}

TEST(RefusedBag, OfAFullDiskNothingKeepsItsName) {
  const test::TempFolder folder;
  const std::string path = (folder / "a.mcap").string();
  EXPECT_TRUE(contains(refusalOf([&] { McapWriter((folder / "none" / "a.mcap").string()); }),
                       "cannot be written"));
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 20'000;
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string why = refusalOf([&] {
    McapWriter writer(path);
    const auto channel = writer.channel("/noise", "std_msgs/msg/String", "string data\n");
    std::uint32_t noise = 1;
    for (int i = 0; i < 2000; ++i) {
      CdrWriter message;
      std::string text(200, 'a');
      for (char& c : text)
        c = static_cast<char>('a' + (noise = noise * 1664525 + 1013904223) / 0x10000000);
      writer.write(channel, i, message.text(text).bytes());
    }
    writer.finish();
  });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_TRUE(contains(why, path + ": cannot be written further; is the disk full?")) << why;
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(RefusedBag, AnUnknownTypeHasNoDefinition) {
  const std::string why = refusalOf([] { fullDefinition("acme_msgs/msg/Rocket", {}); });
  EXPECT_TRUE(contains(why, "acme_msgs/msg/Rocket")) << why;
}

}  // namespace
}  // namespace vir::bags
