#pragma once
/// Columns that are taken by their place because the names over them are not known.
#include <string>
#include <utility>
#include <vector>

#include "vir/tables/layout.h"

namespace vir::tables {

/// Is there a header with a name over each column? What is written between blanks is one only where
/// it names a time or a unit in brackets: a remark may have as many words.
bool hasHeader(const Layout& layout);

/// A column and what it is taken for, as `gyro x`.
using Taken = std::vector<std::pair<int, std::string>>;
/// What is to be said of columns that the header does not name in a known way; empty: there is no
/// header. `by_units`: they were told by the units behind the names.
std::string takenByPosition(const Layout& layout, const Taken& taken, bool by_units = false);
/// With x, y and z behind `what` each.
void addAxes(const int columns[3], const std::string& what, Taken* taken);

}  // namespace vir::tables
