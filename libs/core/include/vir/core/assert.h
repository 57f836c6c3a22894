#pragma once
/// Contract violations throw: a caller's mistake, not bad input.
#include <sstream>
#include <stdexcept>
#include <string>

namespace vir {
inline namespace core {

class AssertionError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

}  // namespace core
}  // namespace vir

/// VIR_ASSERT(n > 0, "n = " << n): throws AssertionError with expression, file, line and values.
#define VIR_ASSERT(expression, values)                                                            \
  do {                                                                                            \
    if (!(expression)) {                                                                          \
      std::ostringstream vir_assert_text;                                                         \
      vir_assert_text << __FILE__ << ':' << __LINE__ << ": not true: " #expression " (" << values \
                      << ')';                                                                     \
      throw ::vir::AssertionError(vir_assert_text.str());                                         \
    }                                                                                             \
  } while (false)
