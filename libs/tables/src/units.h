#pragma once
/// Units behind the names of columns, in any usual notation.
#include <optional>
#include <string>
#include <string_view>

#include "vir/tables/layout.h"

namespace vir::tables {

enum class Quantity { none, length, speed, force, angle, rate, field };

struct Unit {
  Quantity quantity = Quantity::none;
  double factor = 1;  ///< [m], [m/s], [m/s^2], [rad], [rad/s]
};

/// The micro sign, degree sign and superscript two, in UTF-8 and Latin-1, as `u`, `deg`, `2`.
std::string asciiUnits(std::string_view text);

/// Of letters and digits alone, in lower case: `degs` for `deg/s`. Unknown: none.
Unit unitOfText(std::string_view text);
/// `ms`, `[us]`, `milliseconds`.
std::optional<StampUnit> stampUnitOfText(std::string_view text);

/// A name without what exports put in front and units behind: `field_angular_velocity_x`,
/// `imu_ax`, `gyro_x_rad_s`, `acc_x_g`.
std::string bareName(std::string name);

/// In brackets, else behind the name after an underline.
Unit unitAt(const Layout& layout, int column);

/// [rad/s] of what the header says turning rates are in.
double rateUnit(const Layout& layout, int column);
/// [m/s^2]. Headers are copied, numbers are converted: not where gravity contradicts.
double forceUnit(const Layout& layout, const int columns[3]);
/// [m]
double lengthUnit(const Layout& layout, int column);

}  // namespace vir::tables
