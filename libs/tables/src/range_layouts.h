#pragma once
/// Other ways to write ranges than a row of stamp, anchor and range.
#include <cstddef>
#include <string>

#include "vir/tables/ranges.h"

namespace vir::tables {

/// How many different values a column has in the rows at hand.
std::size_t differentValues(const Layout& layout, int column);

/// `src`, `dst`: sets anchor and antenna. False: there are no two such columns, or another one,
/// `anchor`, is called after it.
bool findEnds(const Layout& layout, int anchor, RangeColumns* out);

/// `reference, anchor, tdoa`: sets anchor, reference and range. False: there are no three such
/// columns.
bool findDifference(const Layout& layout, RangeColumns* out);

/// A time of flight with its unit: sets range and unit; without one: the refusal. False: there is
/// no such column.
bool findFlightTime(const Layout& layout, RangeColumns* out);

/// `A1, A2, A3` or `d_0x84, d_0x85`: sets `wide`.
void findWide(const Layout& layout, RangeColumns* out);

}  // namespace vir::tables
