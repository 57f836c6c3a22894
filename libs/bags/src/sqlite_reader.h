#pragma once
#include <memory>
#include <string>

#include "vir/bags/bag_reader.h"

namespace vir::bags {

/// A file of ROS 2 in SQLite (`.db3`). `name` stands for it in messages.
std::unique_ptr<BagReader> openSqlite(const std::string& path, const std::string& name);
/// The same in memory; the bytes must outlive the reader.
std::unique_ptr<BagReader> openSqlite(ByteView bytes, const std::string& name);

}  // namespace vir::bags
