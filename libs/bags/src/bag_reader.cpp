#include "vir/bags/bag_reader.h"

#include <filesystem>
#include <fstream>

#include "bag_folder.h"
#include "mcap_reader.h"
#include "ros1_reader.h"
#include "sqlite_reader.h"

namespace vir::bags {
namespace {

bool packed(const std::string& path) {
  const auto e = std::filesystem::path(path).extension();
  return e == ".zstd" || e == ".zst";
}

}  // namespace

BagKind bagKindOf(const std::string& path) {
  std::error_code ec;
  if (std::filesystem::is_directory(path, ec)) {
    return isBagFolder(path) ? BagKind::folder : BagKind::none;
  }
  char head[16] = {};
  std::ifstream file(path, std::ios::binary);
  file.read(head, sizeof head);
  const std::string_view text(head, static_cast<std::size_t>(file.gcount()));
  if (text.substr(0, 8) == "#ROSBAG " || text.substr(0, 11) == "#ROSRECORD ") return BagKind::ros1;
  if (text.substr(0, 5) == "\x89MCAP") return BagKind::mcap;
  if (text.substr(0, 15) == "SQLite format 3") return BagKind::sqlite;
  if (packed(path) && text.substr(0, 4) == "\x28\xB5\x2F\xFD") {
    const std::string stem = std::filesystem::path(path).stem().string();
    return stem.find(".mcap") != std::string::npos ? BagKind::mcap : BagKind::sqlite;
  }
  return BagKind::none;
}

std::unique_ptr<BagReader> openBag(const std::string& path) {
  const BagKind kind = bagKindOf(path);
  if (kind == BagKind::folder) return openFolder(path);
  if (kind != BagKind::none && packed(path)) return openPacked(path);
  if (kind == BagKind::ros1) return openRos1(InputFile(path));
  if (kind == BagKind::mcap) return openMcap(InputFile(path));
  if (kind == BagKind::sqlite) return openSqlite(path, path);
  throw BagError(path + ": is no ROS 1 bag, MCAP file or ROS 2 bag (a folder with metadata.yaml, or "
                        "a .db3), going by how it begins");
}

}  // namespace vir::bags
