#pragma once
#include <memory>
#include <string>

#include "vir/bags/bag_reader.h"

namespace vir::bags {

/// Does the folder hold bags of ROS 1?
bool isSplitBag(const std::string& folder);

/// Bags of ROS 1 that are one recording: parts of `rosbag record --split` (the same name up to its
/// numbers), or begun within a minute of each other on one machine or several. Messages come in the
/// order in which they were received. Throws BagError where the bags are several recordings.
std::unique_ptr<BagReader> openSplitBag(const std::string& folder);

}  // namespace vir::bags
