#pragma once
/// Bags that others wrote (tests/fixtures/bags), and what is in them.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "vir/bags/bag_reader.h"
#include "vir/bags/message_view.h"
#include "vir_test_paths.h"

namespace vir::bags::test {

inline const TimeNs kStart = 1'600'000'000LL * 1'000'000'000;

inline std::string fixture(const std::string& name) {
  return vir::test::sourceDir() + "/tests/fixtures/bags/" + name;
}

inline Bytes bytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(file), {});
}

/// A message with bytes of its own.
struct Kept {
  Channel channel;
  TimeNs received = 0;
  Bytes data;
};

inline std::vector<Kept> readAll(BagReader& reader) {
  std::vector<Kept> out;
  BagMessage m;
  while (reader.next(&m)) {
    out.push_back({*m.channel, m.received, Bytes(m.data.data, m.data.data + m.data.size)});
  }
  return out;
}

/// All bags of the folder, and whether they describe all their types.
inline std::vector<std::string> allBags() {
  return {"ros1_none.bag",  "ros1_bz2.bag",  "ros1_lz4.bag",      "ros1_unindexed.bag",
          "ros2_none.mcap", "ros2_lz4.mcap", "ros2_zstd.mcap",    "ros2_bare.mcap",
          "ros2_foxy.db3",  "ros2_split",    "ros2_message_zstd", "ros2_file_zstd"};
}

}  // namespace vir::bags::test
