#pragma once
#include <memory>

#include "input_file.h"
#include "vir/bags/bag_reader.h"

namespace vir::bags {

std::unique_ptr<BagReader> openMcap(InputFile file);

}  // namespace vir::bags
