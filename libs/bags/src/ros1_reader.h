#pragma once
#include <memory>

#include "input_file.h"
#include "vir/bags/bag_reader.h"

namespace vir::bags {

/// Bags of ROS 1, version 2.0.
std::unique_ptr<BagReader> openRos1(InputFile file);

}  // namespace vir::bags
