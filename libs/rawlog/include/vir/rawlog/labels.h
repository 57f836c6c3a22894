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
/// Ranges to other robots; what they broadcast begins with it: `PEER:<id>` and
/// `PEER:<id>:ANCHOR:<a>` of positions, `PEER:<id>:WORLD:<w>` of poses.
constexpr const char* kPeerLabel = "PEER";

/// Of a further sensor of the kind of `first`, one of the labels above: `CAM1` of kCameraLabel and
/// "1".
std::string furtherLabel(const std::string& first, const std::string& number);

/// `ANCHOR:<id>`: the robot has just put down this anchor. Empty for any other label.
std::optional<std::uint64_t> deployedAnchorOf(const std::string& label);
bool isDeployedAnchorLabel(const std::string& label);
/// The same of ranges: what this anchor has measured to others.
std::string anchorLabel(std::uint64_t id);

/// `TDOA:<id>`: differences of ranges; this anchor is the reference. Empty for any other label.
std::optional<std::uint64_t> differenceReferenceOf(const std::string& label);
std::string differenceLabel(std::uint64_t reference);
/// What these labels begin with: `TDOA`.
std::string differencesName();

/// Whose broadcast a label announces: of which anchor, or of the sender's pose in which of its
/// worlds (both empty: of the sender's own antenna).
struct BroadcastSource {
  int peer = 0;
  std::optional<std::uint64_t> anchor;
  std::optional<int> world = std::nullopt;
};
/// Does `label` begin as one of another robot's broadcasts, `<peer_label>:`?
bool isBroadcastLabel(const std::string& label, const std::string& peer_label = kPeerLabel);
/// Of `<peer_label>:<id>`, `<peer_label>:<id>:ANCHOR:<a>` and `<peer_label>:<id>:WORLD:<w>`; empty
/// for any other label, also one that only begins so.
std::optional<BroadcastSource> broadcastSourceOf(const std::string& label,
                                                 const std::string& peer_label = kPeerLabel);
std::string broadcastLabel(const BroadcastSource& source,
                           const std::string& peer_label = kPeerLabel);

}  // namespace vir::rawlog
