#pragma once
/// Sensor labels of a recording (docs/recordings.md). Settings may name others for the inputs of
/// an estimator; these are the defaults, and the labels that have a meaning of their own.
#include <cstdint>
#include <optional>
#include <string>

namespace vir::rawlog {

constexpr const char* kCameraLabel = "CAM0";
constexpr const char* kTracksLabel = "TRACKS0";
constexpr const char* kImuLabel = "IMU0";
constexpr const char* kRangeLabel = "UWB0";
constexpr const char* kOdometryLabel = "ODOM";
/// For evaluation only: no estimator reads it.
constexpr const char* kGroundTruthLabel = "GT";
/// Ranges to other robots; what they broadcast begins with it: `PEER:<id>`, `PEER:<id>:ANCHOR:<a>`.
constexpr const char* kPeerLabel = "PEER";

/// `ANCHOR:<id>`: the robot has just put down this anchor. Empty for any other label.
std::optional<std::uint64_t> droppedAnchorOf(const std::string& label);
bool isDroppedAnchorLabel(const std::string& label);
std::string droppedAnchorLabel(std::uint64_t id);

}  // namespace vir::rawlog
