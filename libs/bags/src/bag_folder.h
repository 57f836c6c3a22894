#pragma once
#include <memory>
#include <string>

#include "vir/bags/bag_reader.h"

namespace vir::bags {

/// The files of a folder that ROS 2 recorded, one after the other.
std::unique_ptr<BagReader> openFolder(const std::string& folder);
/// One file that was compressed as a whole (`.zstd`, `.zst`); unpacked into the temporary folder.
std::unique_ptr<BagReader> openPacked(const std::string& path);
/// Does the folder hold files of ROS 2?
bool isBagFolder(const std::string& folder);

}  // namespace vir::bags
