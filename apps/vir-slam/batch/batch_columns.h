#pragma once
/// What the tables of a benchmark tell of a cell, in order.
#include <functional>
#include <string>
#include <vector>

#include "batch/batch_table.h"

namespace vir::app {

/// One column of the table behind the names of row and setting.
struct BatchColumn {
  const char* head;
  std::function<std::string(const BatchCell&)> text;
  bool ate = false;       ///< the one that the best setting is found by
  bool terminal = false;  ///< shown there, where there is no room for all
};
const std::vector<BatchColumn>& batchColumns();

std::string titleOf(const BatchSetting& setting);

}  // namespace vir::app
