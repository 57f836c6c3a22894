#include "vir/bags/bag_reader.h"

#include <filesystem>
#include <fstream>

#include "bag_folder.h"
#include "mcap_reader.h"
#include "ros1_reader.h"
#include "split_bag.h"
#include "sqlite_reader.h"

namespace vir::bags {
namespace {

bool packed(const std::string& path) {
  const auto e = std::filesystem::path(path).extension();
  return e == ".zstd" || e == ".zst";
}

/// By its first bytes.
BagKind kindOf(std::string_view head) {
  const auto begins = [&](std::string_view with) { return head.substr(0, with.size()) == with; };
  if (begins("#ROSBAG ") || begins("#ROSRECORD ")) return BagKind::ros1;
  if (begins("\x89MCAP")) return BagKind::mcap;
  return begins("SQLite format 3") ? BagKind::sqlite : BagKind::none;
}

}  // namespace

BagKind bagKindOf(const std::string& path) {
  std::error_code ec;
  if (std::filesystem::is_directory(path, ec)) {
    if (isBagFolder(path)) return BagKind::folder;
    return isSplitBag(path) ? BagKind::ros1_folder : BagKind::none;
  }
  char head[16] = {};
  std::ifstream file(path, std::ios::binary);
  file.read(head, sizeof head);
  const std::string_view text(head, static_cast<std::size_t>(file.gcount()));
  if (packed(path) && text.substr(0, 4) == "\x28\xB5\x2F\xFD") {
    const std::string stem = std::filesystem::path(path).stem().string();
    return stem.find(".mcap") != std::string::npos ? BagKind::mcap : BagKind::sqlite;
  }
  return kindOf(text);
}

std::unique_ptr<BagReader> openBag(ByteView bytes, const std::string& name) {
  const BagKind kind = kindOf(bytes.text());
  if (kind == BagKind::ros1) return openRos1(InputFile(bytes, name));
  if (kind == BagKind::mcap) return openMcap(InputFile(bytes, name));
  if (kind == BagKind::sqlite) return openSqlite(bytes, name);
  throw BagError(name + ": is no ROS 1 bag, MCAP file or SQLite file, going by how it begins");
}

std::unique_ptr<BagReader> openBag(const std::string& path) {
  const BagKind kind = bagKindOf(path);
  if (kind == BagKind::folder) return openFolder(path);
  if (kind == BagKind::ros1_folder) return openSplitBag(path);
  if (kind != BagKind::none && packed(path)) return openPacked(path);
  if (kind == BagKind::ros1) return openRos1(InputFile(path));
  if (kind == BagKind::mcap) return openMcap(InputFile(path));
  if (kind == BagKind::sqlite) return openSqlite(path, path);
  throw BagError(path +
                 ": is no ROS 1 bag, MCAP file or ROS 2 bag (a folder with metadata.yaml, or "
                 "a .db3), going by how it begins");
}

}  // namespace vir::bags
