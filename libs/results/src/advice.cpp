#include "vir/results/advice.h"

namespace vir::results {
namespace {

/// A part of a reason, and what helps.
struct Remedy {
  const char* of;
  const char* advice;
};

constexpr Remedy kRemedies[] = {
    {"standing still", "move sideways, or up and down; turning alone does not do"},
    {"parallax", "move sideways, or up and down; turning alone does not do"},
    {"no excitation", "move faster, and not at a constant speed: speed up, slow down, turn"},
    {"scale uncertain", "move faster, and not at a constant speed: speed up, slow down, turn"},
    {"too few images", "keep moving"},
    {"waiting for images", "no usable image has come: is the camera on, and its label right?"},
    {"too few tracks", "let the camera see something with texture, in light, farther away"},
    {"no landmarks", "let the camera see what it saw before"},
    {"image not usable", "more light, a cleaner lens, nothing in front of the camera"},
    {"time offset", "turn the camera to and fro"},
    {"camera's model", "`vir-slam check` of the recording tells what does not fit"},
    {"gyro bias", "hold it still for a second"},
    {"no IMU readings", "no readings of the IMU come: is it on, and its label right?"},
};

}  // namespace

std::string adviceFor(const StateEstimate& e) {
  if (e.health == Health::ok || e.health == Health::standing) return "";
  for (const Remedy& remedy : kRemedies) {
    if (e.reason.find(remedy.of) != std::string::npos) return remedy.advice;
  }
  return "";
}

std::string adviceFor(const std::vector<Anchor>& anchors) {
  if (anchors.empty()) return "no ranges yet";
  for (const Anchor& a : anchors) {
    if (!a.advice.empty()) return "anchor " + std::to_string(a.id) + ": " + a.advice;
  }
  return "";
}

}  // namespace vir::results
