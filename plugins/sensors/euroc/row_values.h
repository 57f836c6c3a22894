#pragma once
/// Values of the fields of a row, or why there are none.
#include <string>
#include <string_view>
#include <vector>

#include "problem_log.h"
#include "row_cursor.h"
#include "vir/core/time.h"
#include "vir/geometry/so3.h"
#include "vir/tables/anchor_names.h"
#include "vir/tables/by_position.h"
#include "vir/tables/layout.h"

namespace vir::euroc {

using Fields = std::vector<std::string_view>;

/// How to read the stamps of a file.
struct Stamps {
  int column = 0;
  tables::StampUnit unit = tables::StampUnit::nanoseconds;
  int nanoseconds = -1;  ///< column of what belongs to whole seconds
  TimeNs offset = 0;     ///< to be added to all of them
};

/// Notes what is unusual in them. `typical_step_s`: between rows [s]; `seconds_expected`: not
/// nanoseconds.
Stamps stampsOf(const std::string& path, const tables::Layout& layout, int column,
                double typical_step_s, bool seconds_expected, ProblemLog* log);

bool enough(const Fields& f, int last, RowFault* fault);
const std::string_view& at(const Fields& f, int column);
bool stamp(const Fields& f, const Stamps& stamps, TimeNs* t, RowFault* fault);
/// A finite number.
bool value(const Fields& f, int column, double* out, RowFault* fault);
bool vector(const Fields& f, const int columns[3], Vec3* out, RowFault* fault);
/// Always false.
bool implausible(RowFault* fault, const std::string& text);
bool anchorId(std::string_view field, tables::AnchorNames* names, int* id, RowFault* fault);
/// Notes that numbers are multiplied; nothing where the factor is 1.
void sayUnit(const std::string& path, const char* what, double factor, const char* unit,
             ProblemLog* log);
/// Notes and counts columns whose names are not known, where there is a header.
void sayByPosition(const std::string& path, const tables::Layout& layout,
                   const tables::Taken& taken, bool by_units, ProblemLog* log);

}  // namespace vir::euroc
