#pragma once
/// Surveyed anchors from a table.
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "vir/types/survey.h"

namespace vir::ranging {

/// what(): `NAME:LINE: what is wrong; what is allowed`.
class SurveyTableError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Numbers of anchors that are called by name.
using AnchorNumbers = std::map<std::string, std::uint64_t>;
/// Of `name=number`, repeated, where a name's blanks are `%20` and its per cent signs `%25`. Throws
/// std::runtime_error for anything else.
AnchorNumbers anchorNumbers(const std::string& text);
/// The inverse.
std::string anchorNumbersText(const AnchorNumbers& numbers);

/// `id,x,y,z` and, if there is one, `sigma`, with any separator; columns by the names of a header
/// in any order, else in this one; a unit in brackets in the header (`x [mm]`). An id is a name of
/// `numbers`, a decimal number, one in 0x notation, or else hexadecimal digits as devices print
/// them. Strict: throws SurveyTableError naming `name` and the line for anything unexpected, and
/// for a table without anchors.
std::vector<SurveyedAnchor> surveyFromText(std::string_view text, const std::string& name,
                                           const AnchorNumbers& numbers = {});

}  // namespace vir::ranging
