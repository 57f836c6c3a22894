#pragma once
/// Units that a header names and nobody here knows.
#include <string>
#include <vector>

#include "vir/tables/layout.h"

namespace vir::tables {

/// What is to be said of the units in brackets behind the names of these columns, as `[furlong]`;
/// empty: all are known, or none is named.
std::string unknownUnits(const Layout& layout, const std::vector<int>& columns);
/// The same of the column of stamps, which are `taken` to be in some unit; empty also for dates and
/// for what names a clock, as `[UTC]`.
std::string unknownStampUnit(const Layout& layout, int column, StampUnit taken);

}  // namespace vir::tables
