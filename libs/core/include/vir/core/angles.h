#pragma once
/// Numbers of the circle.

namespace vir {
inline namespace core {

constexpr double kPi = 3.14159265358979323846;
constexpr double kRadPerDeg = kPi / 180;
constexpr double kDegPerRad = 180 / kPi;

}  // namespace core
}  // namespace vir
