#pragma once
/// Numbers, and yes or no, from text, the same with every locale.
#include <charconv>
#include <string_view>
#include <system_error>
#include <type_traits>

namespace vir {
inline namespace core {

/// All of `text` as a decimal number: no blank before or behind it, nothing else behind it, no
/// hexadecimal. One `+` may stand before it. `inf` and `nan` are numbers here; what is too large
/// for a double becomes infinite, what is too small 0. False, and `value` as it was, for anything
/// else.
bool parseNumber(std::string_view text, double* value);

/// The same, but false for what is infinite, too large for a double, or `nan`.
bool parseFinite(std::string_view text, double* value);

/// `true`, `yes` or `1`; `false`, `no` or `0`; in any case of letters. False, and `value` as it
/// was, for anything else.
bool parseBool(std::string_view text, bool* value);

/// All of `text` as a whole number that `T` can hold: digits of `base` (2 to 36) and, where `T` has
/// a sign, a `-` before them; no `+`, no `0x`, no blank. False, and `value` as it was, for anything
/// else.
template <typename T, typename = std::enable_if_t<std::is_integral_v<T>>>
bool parseNumber(std::string_view text, T* value, int base = 10) {
  T parsed = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, parsed, base);
  if (error != std::errc() || end != last) return false;
  *value = parsed;
  return true;
}

}  // namespace core
}  // namespace vir
