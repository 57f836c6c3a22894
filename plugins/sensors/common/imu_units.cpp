#include "imu_units.h"

#include <cstddef>
#include <utility>

#include "vir/core/angles.h"

namespace vir {
namespace {

constexpr double kGravity = 9.80665;

using Unit = std::pair<const char*, double>;
constexpr Unit kAcceleration[] = {
    {"auto", 0},     {"m/s2", 1},   {"g", kGravity},  {"mg", kGravity / 1000},
    {"cm/s2", 0.01}, {"-m/s2", -1}, {"-g", -kGravity}};  // at rest it points down, as on iPhones
constexpr Unit kRate[] = {
    {"auto", 0}, {"rad/s", 1}, {"deg/s", kRadPerDeg}, {"mdeg/s", kRadPerDeg / 1000}};

template <std::size_t n>
double find(const Unit (&units)[n], const std::string& name) {
  for (const auto& [known, value] : units) {
    if (name == known) return value;
  }
  return 0;
}

template <std::size_t n>
std::vector<std::string> names(const Unit (&units)[n]) {
  std::vector<std::string> out;
  for (const Unit& unit : units) out.emplace_back(unit.first);
  return out;
}

}  // namespace

double accelerationUnit(const std::string& name) { return find(kAcceleration, name); }
double rateUnit(const std::string& name) { return find(kRate, name); }
std::vector<std::string> accelerationUnits() { return names(kAcceleration); }
std::vector<std::string> rateUnits() { return names(kRate); }

}  // namespace vir
