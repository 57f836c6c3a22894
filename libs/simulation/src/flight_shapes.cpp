#include "flight_shapes.h"

#include <algorithm>
#include <cmath>

#include "vir/core/angles.h"

namespace vir::simulation {
namespace {

/// Along the corners and round again, as far as it goes.
std::vector<Vec3> line(const std::vector<Vec3>& corners, double length) {
  std::vector<Vec3> out{corners.front()};
  for (std::size_t k = 1; length > 0; ++k) {
    const Vec3& to = corners[k % corners.size()];
    const Vec3 step = to - out.back();
    const double n = step.norm();
    if (n < 1e-9) continue;
    out.push_back(n <= length ? to : Vec3(out.back() + step * (length / n)));
    length -= n;
  }
  return out;
}

/// To the last corner and the same way back.
std::vector<Vec3> thereAndBack(std::vector<Vec3> corners, double length) {
  for (std::size_t k = corners.size() - 1; k-- > 1;) corners.push_back(corners[k]);
  return line(corners, length);
}

std::vector<Vec3> eight(double length) {
  std::vector<Vec3> corners;
  for (int k = 0; k < 200; ++k) {
    const double a = 2 * kPi * k / 200;
    corners.emplace_back(6 * std::sin(a), 3 * std::sin(2 * a), 0);
  }
  return line(corners, length);
}

std::vector<Vec3> corridor(double length) {
  const double half = std::max(1.0, length / 2 - 1.5);
  return line({{0, 0, 0}, {half, 0, 0}, {half, 3, 0}, {0, 3, 0}}, length);
}

std::vector<Vec3> route(double length) {
  return line({{0, 0, 0},
               {8, 0, 0},
               {8, 5, 0.5},
               {11, 5, 1},
               {11, 0, 0.5},
               {20, 0, 0},
               {20, 14, 1},
               {13, 14, 1.5},
               {13, 9, 1.5},
               {5, 9, 0.5},
               {5, 14, 0},
               {0, 14, 0}},
              length);
}

/// Circles of 3 m radius, 1.2 m higher each, four up and four down.
std::vector<Vec3> helix(double length) {
  constexpr int kPerTurn = 60, kTurns = 4;
  std::vector<Vec3> corners;
  for (int k = 0; k < 2 * kTurns * kPerTurn; ++k) {
    const double a = 2 * kPi * k / kPerTurn;
    const int rising = std::min(k, 2 * kTurns * kPerTurn - k);
    corners.emplace_back(3 * std::sin(a), 3 - 3 * std::cos(a), 1.2 * rising / kPerTurn);
  }
  return line(corners, length);
}

/// Up one aisle and down the next, five of them, 3.5 m apart; back along the end of the racks.
std::vector<Vec3> warehouse(double length) {
  constexpr double kAisle = 18, kApart = 3.5;
  std::vector<Vec3> corners;
  for (int k = 0; k < 5; ++k) {
    const double y = kApart * k;
    const double height = 0.4 * (k % 3);
    corners.emplace_back(k % 2 == 0 ? 0 : kAisle, y, height);
    corners.emplace_back(k % 2 == 0 ? kAisle : 0, y, height);
  }
  corners.emplace_back(kAisle + 2, 4 * kApart, 0);
  corners.emplace_back(kAisle + 2, -2, 0);
  corners.emplace_back(0, -2, 0);
  return line(corners, length);
}

std::vector<Vec3> letterS() {
  std::vector<Vec3> out;
  const auto arc = [&out](double cx, double cy, double from_deg, double to_deg) {
    for (int k = 0; k <= 12; ++k) {
      const double a = (from_deg + (to_deg - from_deg) * k / 12) * kPi / 180;
      out.emplace_back(cx + 2 * std::cos(a), cy + 2 * std::sin(a), 0.1 * k / 12);
    }
  };
  arc(2, 2, -150, 90);
  arc(2, 6, -90, -330);
  const Vec3 start = out.front();
  for (Vec3& p : out) p -= start;
  return out;
}

}  // namespace

std::vector<std::string> shapeNames() {
  return {"eight",    "corridor", "route",    "helix",    "warehouse",
          "letter_m", "letter_i", "letter_s", "letter_t", "stop_and_go"};
}

std::vector<Vec3> shapePoints(const std::string& name, double length) {
  if (name == "eight") return eight(length);
  if (name == "corridor") return corridor(length);
  if (name == "route") return route(length);
  if (name == "helix") return helix(length);
  if (name == "warehouse") return warehouse(length);
  // Letters 8 m high, as seen from above.
  if (name == "letter_m") {
    return thereAndBack({{0, 0, 0}, {0, 8, 0.3}, {3, 3, 0.6}, {6, 8, 0.3}, {6, 0, 0}}, length);
  }
  if (name == "letter_i") return thereAndBack({{0, 0, 0}, {0, 8, 0.8}}, length);
  if (name == "letter_s") return thereAndBack(letterS(), length);
  if (name == "letter_t") {
    return thereAndBack({{0, 0, 0}, {0, 8, 0.4}, {-3, 8, 0.6}, {3, 8, 0.6}}, length);
  }
  if (name == "stop_and_go") {
    return line({{0, 0, 0}, {10, 0, 0}, {10, 6, 0.5}, {0, 6, 0.5}}, length);
  }
  return {};
}

}  // namespace vir::simulation
