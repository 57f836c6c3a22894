#pragma once
/// Units of length as settings call them.
#include <optional>
#include <string_view>

namespace vir {
inline namespace core {

struct LengthUnit {
  const char *name, *in_words;
  double in_m;
};

inline constexpr LengthUnit kLengthUnits[] = {
    {"m", "metres", 1},     {"cm", "centimetres", 0.01}, {"mm", "millimetres", 0.001},
    {"ft", "feet", 0.3048}, {"in", "inches", 0.0254},    {"yd", "yards", 0.9144},
};
inline constexpr const char* kLengthUnitNames = "m|cm|mm|ft|in|yd";

/// [m]; empty for a name that is none of theirs.
inline std::optional<double> lengthUnitOf(std::string_view name) {
  for (const LengthUnit& u : kLengthUnits) {
    if (name == u.name) return u.in_m;
  }
  return std::nullopt;
}

}  // namespace core
}  // namespace vir
